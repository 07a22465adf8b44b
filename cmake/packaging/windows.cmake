# cmake -D BUILD=build/windows -P cmake/packaging/windows.cmake: writes the archive
# BUILD/aula-VERSION-windows-x86_64.zip of the program, the C interface, and, if they are built, the
# CLAP and VST3 plugins and the package of Unity, with the libraries that they need and the licences.
# Needs the targets aula and aula_c.
cmake_minimum_required(VERSION 3.25)
get_filename_component(BUILD "${BUILD}" ABSOLUTE)
load_cache("${BUILD}" READ_WITH_PREFIX "" CMAKE_PROJECT_VERSION AULA_WINDOWS_LIBRARIES)
set(name "aula-${CMAKE_PROJECT_VERSION}-windows-x86_64")
set(root "${BUILD}/archive/${name}")
file(REMOVE_RECURSE "${root}")
foreach(component program c clap vst3 unity license)
    execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --component ${component}
                            --prefix "${root}" --strip
                    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
foreach(file bin/aula.exe bin/libaula.dll bin/aula_sound_reader.exe bin/aula_sofa_reader.exe)
    if(NOT EXISTS "${root}/${file}")
        message(FATAL_ERROR "${file} is missing; build the targets aula and aula_c")
    endif()
endforeach()
# The folders of plugins have what they need, to work where a user copies them.
file(GLOB needed "${AULA_WINDOWS_LIBRARIES}/bin/*.dll")
list(TRANSFORM needed REPLACE ".*/" "${root}/bin/")
file(GLOB plugins "${root}/lib/clap/aula/aula.clap" "${root}/lib/vst3/aula.vst3/Contents/*/aula.vst3"
     "${root}/lib/unity/aula/Plugins/*/audiopluginaula.dll")
foreach(plugin IN LISTS plugins)
    cmake_path(GET plugin PARENT_PATH folder)
    file(COPY ${needed} "${root}/bin/aula_sound_reader.exe" "${root}/bin/aula_sofa_reader.exe"
         DESTINATION "${folder}")
endforeach()
foreach(format clap vst3)
    file(REMOVE_RECURSE "${root}/share/doc/aula-${format}")
    if(EXISTS "${root}/lib/${format}")
        configure_file("${CMAKE_CURRENT_LIST_DIR}/${format}.copyright"
                       "${root}/share/doc/aula/libraries/${format}.copyright" COPYONLY)
    endif()
endforeach()
file(COPY "${AULA_WINDOWS_LIBRARIES}/licences/" DESTINATION "${root}/share/doc/aula/libraries")
file(COPY "${CMAKE_CURRENT_LIST_DIR}/../debian/copyright" DESTINATION "${root}/share/doc/aula")
execute_process(COMMAND "${CMAKE_COMMAND}" -E tar cf "${BUILD}/${name}.zip" --format=zip "${name}"
                WORKING_DIRECTORY "${BUILD}/archive" COMMAND_ERROR_IS_FATAL ANY)
message("${BUILD}/${name}.zip")
