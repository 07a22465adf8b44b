# Warnings for Aula's code; not exported.
add_library(aula_warnings INTERFACE)
# Compilers warn that the ABI of vectors depends on the instruction set; all code is built with one.
target_compile_options(aula_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                               -Wno-psabi)
# Clang 14 counts explicit conversions, such as double{x}, as promotions.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(aula_warnings INTERFACE -Wdouble-promotion)
endif()
# GCC 12 reports false overlaps in std::string (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(aula_warnings INTERFACE -Wno-restrict)
endif()
# GCC collects garbage from 128 MB on, which takes up to a tenth of the time of long steps
# (-ftime-report prints it). From 512 MB on it needs a quarter more memory; its output is the same.
add_compile_options("$<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=524288>")
# Hardening for readers of untrusted files; sanitizers have separate checks.
if(WIN32)
    add_link_options(-fstack-protector-strong)  # its functions are in a library
else()
    add_link_options(-Wl,-z,relro,-z,now)
endif()
add_compile_options(-fstack-protector-strong)
if(NOT AULA_SANITIZE)
    add_compile_options("$<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")
endif()
if(AULA_SANITIZE)
    add_compile_options(-fsanitize=${AULA_SANITIZE} -fno-omit-frame-pointer
                        -fno-sanitize-recover=all)
    add_link_options(-fsanitize=${AULA_SANITIZE})
endif()
if(AULA_FUZZ)
    add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# The headers that most sources include. aula_engine precompiles them for the libraries,
# aula_documents for the parts of the program, whose options differ. Sources with further options
# cannot use them, with GCC 14 not even with another -O level, nor can aula_devices, for which
# PortAudio demands -pthread. Rarer headers, such as <thread>, would cost more time in the other
# sources than they save. The preset dev compiles without precompiled headers, to find missing ones.
set(AULA_PRECOMPILED_HEADERS
    <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <glm/geometric.hpp> <limits>
    <map> <memory> <numbers> <optional> <span> <string> <utility> <vector>)

# aula_library(NAME COMPONENT C SOURCES ... HEADERS ...): the static library aula::NAME of component
# C. HEADERS are its public headers, below include/ and included as <aula/...>. Inside the project
# all other headers are included from the root of the tree, as "engine/rays/ray_scene.h".
function(aula_library name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "COMPONENT" "SOURCES;HEADERS")
    add_library(aula_${name} STATIC ${arg_SOURCES})
    add_library(aula::${name} ALIAS aula_${name})
    # Shared libraries and plugins of other projects link it, and export none of its symbols.
    set_target_properties(aula_${name} PROPERTIES
        EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
        CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    list(TRANSFORM arg_HEADERS PREPEND include/)
    target_sources(aula_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
    target_include_directories(aula_${name} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>")
    target_compile_features(aula_${name} PUBLIC cxx_std_20)
    # No result depends on errno or floating-point traps; without them loops vectorise.
    target_compile_options(aula_${name} PRIVATE -fno-math-errno -fno-trapping-math)
    target_link_libraries(aula_${name} PRIVATE $<BUILD_INTERFACE:aula_warnings>)
    install(TARGETS aula_${name} EXPORT aula-${arg_COMPONENT} FILE_SET HEADERS)
endfunction()

# aula_embedded_program(LIBRARY NAME SOURCE EMBEDDING DEPENDENCY...): the program aula_NAME for a
# ContainedProcess, whose file EMBEDDING, a source of the library, includes as AULA_PROGRAM. It is
# never instrumented because its memory is limited.
function(aula_embedded_program library name source embedding)
    add_executable(aula_${name}
        "${source}"
        "${PROJECT_SOURCE_DIR}/engine/process/contained_program_${AULA_SYSTEM}.cpp")
    set(folder "${CMAKE_CURRENT_BINARY_DIR}")
    if(WIN32)
        set(folder "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
        install(TARGETS aula_${name} COMPONENT c)
    endif()
    set_target_properties(aula_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${folder}")
    target_include_directories(aula_${name} PRIVATE "${PROJECT_SOURCE_DIR}"
                                                    "${PROJECT_SOURCE_DIR}/engine")
    target_compile_options(aula_${name} PRIVATE -fno-sanitize=all)
    target_link_options(aula_${name} PRIVATE -fno-sanitize=all)
    target_link_libraries(aula_${name} PRIVATE ${ARGN} aula_warnings)
    set(program "${folder}/aula_${name}${CMAKE_EXECUTABLE_SUFFIX}")
    set_source_files_properties("${embedding}" PROPERTIES
        OBJECT_DEPENDS "${program}" COMPILE_DEFINITIONS "AULA_PROGRAM=\"${program}\"")
    add_dependencies(${library} aula_${name})  # make has no rule for a program of another target
endfunction()
