# Unity builds: the sources of a folder that belong to one target are compiled together, so that
# their headers are parsed once. Names in anonymous namespaces are therefore unique in a folder; a
# test whose names recur in its folder is in a namespace with the name of its file. Sources with
# further options or definitions are compiled alone. -DCMAKE_UNITY_BUILD=OFF, as in the preset dev,
# compiles each source alone, to find missing includes.

# aula_group_by_folder(DIRECTORY): groups the sources of all targets of the directory and below.
function(aula_group_by_folder directory)
    get_property(targets DIRECTORY "${directory}" PROPERTY BUILDSYSTEM_TARGETS)
    foreach(target IN LISTS targets)
        get_target_property(sources ${target} SOURCES)
        set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
        foreach(source IN LISTS sources)
            cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${directory}" NORMALIZE)
            cmake_path(IS_PREFIX PROJECT_BINARY_DIR "${source}" generated)
            if(source MATCHES "\\.cpp$" AND NOT generated)
                cmake_path(GET source PARENT_PATH folder)
                file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}" "${folder}")
                string(MAKE_C_IDENTIFIER "${folder}" group)
                set_source_files_properties("${source}" TARGET_DIRECTORY ${target}
                                            PROPERTIES UNITY_GROUP ${group})
            endif()
        endforeach()
    endforeach()
    get_property(subdirectories DIRECTORY "${directory}" PROPERTY SUBDIRECTORIES)
    foreach(subdirectory IN LISTS subdirectories)
        aula_group_by_folder("${subdirectory}")
    endforeach()
endfunction()

aula_group_by_folder("${CMAKE_CURRENT_SOURCE_DIR}")
# Names of one source are global in the others, and GCC takes sources that are included for headers.
# Clang has no warning of shadowed local names only.
if(CMAKE_UNITY_BUILD)
    target_compile_options(aula_warnings INTERFACE -Wno-shadow)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        target_compile_options(aula_warnings INTERFACE -Wshadow=local -Wno-subobject-linkage)
    endif()
endif()
