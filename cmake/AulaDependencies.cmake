# Third-party libraries of the components, each searched for only if it is needed. Used by Aula's
# build and by find_package(aula).
include(CMakeFindDependencyMacro)

# Within find_package(aula) a missing package makes Aula not found. In Aula's own build it is an
# error: find_dependency would end CMakeLists.txt at that line, with a warning and nothing to build.
macro(aula_find_dependency)
    if(CMAKE_FIND_PACKAGE_NAME STREQUAL "aula")
        find_dependency(${ARGN})
    else()
        find_package(${ARGN} REQUIRED)
    endif()
endmacro()

macro(aula_find_engine_dependencies)
    aula_find_dependency(Threads)
    aula_find_dependency(glm)
    # Embree 4, else 3. An installed library needs the version that it was compiled for: the names
    # of their functions are the same, the arguments differ. aulaConfig.cmake states it.
    if(NOT AULA_EMBREE_MAJOR)
        find_package(embree 4 QUIET)
        if(embree_FOUND)
            set(AULA_EMBREE_MAJOR 4)
        else()
            set(AULA_EMBREE_MAJOR 3)
        endif()
    endif()
    aula_find_dependency(embree ${AULA_EMBREE_MAJOR})
endmacro()

macro(aula_find_audio_dependencies)
    aula_find_dependency(Threads)
    aula_find_dependency(PkgConfig)
    pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)
    pkg_check_modules(SOXR REQUIRED IMPORTED_TARGET soxr)
    pkg_check_modules(EBUR128 REQUIRED IMPORTED_TARGET libebur128)
    pkg_check_modules(KISSFFT REQUIRED IMPORTED_TARGET kissfft-float)
endmacro()

macro(aula_find_c_dependencies)
endmacro()

macro(aula_find_room_dependencies)
endmacro()

macro(aula_find_devices_dependencies)
    aula_find_dependency(PkgConfig)
    pkg_check_modules(LIBLO REQUIRED IMPORTED_TARGET liblo)
endmacro()
