# cpack -G DEB: one Debian package for each component of the installation.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "Aula")
# The maintainer of a package is the person who builds it, by the variables of Debian's tools.
set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
if("$ENV{DEBFULLNAME}" STREQUAL "" OR "$ENV{DEBEMAIL}" STREQUAL "")
    set(maintainer "Unofficial build <unofficial-build@aula.invalid>")
endif()
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_POST_BUILD_SCRIPTS "${PROJECT_SOURCE_DIR}/cmake/debian/remove_scripts.cmake")
set(CPACK_COMPONENTS_ALL "")

# The changelog of the packages.
set(changelog "${PROJECT_BINARY_DIR}/debian/changelog")
file(CONFIGURE OUTPUT "${changelog}" @ONLY CONTENT
"aula (@PROJECT_VERSION@) stable; urgency=medium

  * Release @PROJECT_VERSION@.

 -- @maintainer@  Sat, 28 Nov 2026 00:00:00 +0000
")
execute_process(COMMAND gzip -9 -n -k -f "${changelog}" COMMAND_ERROR_IS_FATAL ANY)

# find_packages(RESULT LIBRARY...): the packages of shared libraries, as a field of a package.
function(find_packages result)
    set(packages "")
    foreach(library IN LISTS ARGN)
        file(REAL_PATH "${library}" library)
        execute_process(COMMAND dpkg-query --search "${library}"
                        OUTPUT_VARIABLE owner ERROR_QUIET RESULT_VARIABLE status)
        if(status EQUAL 0 AND library MATCHES "\\.so" AND owner MATCHES "^([^:, ]+)")
            list(APPEND packages "${CMAKE_MATCH_1}")
        endif()
    endforeach()
    list(REMOVE_DUPLICATES packages)
    list(JOIN packages ", " packages)
    set(${result} "${packages}" PARENT_SCOPE)
endfunction()
# Of the libraries that dpkg-shlibdeps does not see: those of embedded programs, and those that the
# program loads to play.
set(embedded ${SNDFILE_LINK_LIBRARIES} ${MYSOFA_LINK_LIBRARIES} ${AULA_HDF5_LIBRARIES})
list(FILTER embedded INCLUDE REGEX "/lib(sndfile|mysofa|hdf5|sz)[^/]*\\.so$")
find_packages(embedded_depends ${embedded})
find_packages(played ${JACK_LINK_LIBRARIES} ${ALSA_LINK_LIBRARIES} ${pkgcfg_lib_GLFW_glfw})

# aula_package(COMPONENT PACKAGE SECTION DEPENDS DESCRIPTION): the package of a component. Its
# copyright and changelog are installed only into the package.
macro(aula_package component package section depends description)
    string(TOUPPER "${component}" upper)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
    set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
    set(CPACK_COMPONENT_${upper}_DESCRIPTION "${description}")
    install(FILES "${PROJECT_SOURCE_DIR}/cmake/debian/copyright" "${changelog}.gz"
            DESTINATION share/doc/${package} COMPONENT ${component} EXCLUDE_FROM_ALL)
endmacro()

set(version "${PROJECT_VERSION}")
aula_package(c libaula0 libs "${embedded_depends}"
"Shared library: libaula.so.0 makes rooms audible block by block, through an
 interface in C.")
aula_package(dev libaula-dev libdevel "libaula0 (= ${version})"
"Development files: the header aula.h of the interface in C, and headers,
 static libraries and CMake files of the interface in C++.")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS
    "cmake, pkg-config, libembree-dev, libglm-dev, libsndfile1-dev, libsoxr-dev, libebur128-dev, libkissfft-dev")
aula_package(program aula sound "${embedded_depends}"
"The program: it traces sound through a scene and plays what a moving listener
 hears, live in a window or the terminal, or to a file. It measures impulse
 responses and the parameters of ISO 3382. Scenes and sounds are included.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "${played}")
if(TARGET aula_plugin)
    aula_package(lv2 aula-lv2 sound "${embedded_depends}"
"LV2 plugins: reverberation of a room from its geometry and materials, with a
 moving source and a moving listener.")
endif()
if(TARGET aula_clap)
    aula_package(clap aula-clap sound "${embedded_depends}"
"CLAP plugins: reverberation of a room from its geometry and materials, with a
 moving source and a moving listener.")
endif()
if(TARGET aula_vst3)
    aula_package(vst3 aula-vst3 sound "${embedded_depends}"
"VST3 plugins: reverberation of a room from its geometry and materials, with a
 moving source and a moving listener.")
endif()
# What editors load.
if(AULA_EDITOR)
    find_packages(shown ${pkgcfg_lib_XLIB_X11})
    if(shown)
        string(APPEND shown ", ")
    endif()
    foreach(format LV2 CLAP VST3)
        set(CPACK_DEBIAN_${format}_PACKAGE_RECOMMENDS "${shown}libgl1")
    endforeach()
endif()
# The module is for the interpreter of the distribution, of one minor version.
if(TARGET aula_python AND Python_EXECUTABLE STREQUAL "/usr/bin/python3")
    execute_process(COMMAND "${Python_EXECUTABLE}" -c
                            "import sys; print('python3 (>= {0}.{1}), python3 (<< {0}.{2})'.format(
                             *sys.version_info[:2], sys.version_info[1] + 1))"
                    OUTPUT_VARIABLE python_depends OUTPUT_STRIP_TRAILING_WHITESPACE
                    COMMAND_ERROR_IS_FATAL ANY)
    aula_package(python python3-aula python "${python_depends}, python3-numpy, ${embedded_depends}"
"Python package: impulse responses, parameters of ISO 3382, echograms and
 sound from the geometry and materials of rooms, as arrays of NumPy.")
    set(scripts "${PROJECT_SOURCE_DIR}/cmake/debian/python3-aula")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${scripts}/postinst;${scripts}/prerm")
endif()

# The library's dependants, and the linker's cache.
set(control "${PROJECT_BINARY_DIR}/debian")
file(WRITE "${control}/shlibs" "libaula 0 libaula0 (>= ${version})\n")
file(WRITE "${control}/triggers" "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_C_PACKAGE_CONTROL_EXTRA "${control}/shlibs;${control}/triggers")
include(CPack)
