# aula_module(TARGET SYMBOL...): a module that programs of others load exports only these symbols
# and stays in memory: threads of the libraries may run when a host unloads it.
#
# On Windows the sources mark what is exported. The libraries that the module needs and the programs
# that read files for it are copied beside it, and prepare_module() (engine/process/module.h) loads
# the libraries from there.
if(NOT WIN32)
    function(aula_module target)
        list(JOIN ARGN "; " symbols)
        set(map "${CMAKE_CURRENT_BINARY_DIR}/${target}.map")
        file(CONFIGURE OUTPUT "${map}" CONTENT "{ global: ${symbols}; local: *; };\n")
        set_target_properties(${target} PROPERTIES LINK_DEPENDS "${map}"
            CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
        target_link_options(${target} PRIVATE -Wl,-z,nodelete -Wl,-z,defs -Wl,--exclude-libs,ALL
            "-Wl,--version-script=${map}")
    endfunction()
    return()
endif()

# A jump to each function of the libraries, whose addresses prepare_module() finds.
file(GLOB libraries CONFIGURE_DEPENDS "${AULA_WINDOWS_LIBRARIES}/bin/*.dll")
set(names "")
set(jumps "")
set(count 0)
foreach(library IN LISTS libraries)
    execute_process(COMMAND "${CMAKE_OBJDUMP}" -p "${library}" OUTPUT_VARIABLE exported
                    COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "\n\t\\[ *[0-9]+\\] [A-Za-z0-9_]+" exported "${exported}")
    cmake_path(GET library FILENAME file)
    foreach(line IN LISTS exported)
        string(REGEX REPLACE ".* " "" function "${line}")
        math(EXPR offset "${count} * 8")
        math(EXPR count "${count} + 1")
        string(APPEND names "    {L\"${file}\", \"${function}\"},\n")
        string(APPEND jumps "AULA_FUNCTION(${function}, ${offset});\n")
    endforeach()
endforeach()
if(count EQUAL 0)
    message(FATAL_ERROR "no library in ${AULA_WINDOWS_LIBRARIES}/bin; .ci/windows makes them")
endif()
set(AULA_MODULE_SOURCE "${PROJECT_BINARY_DIR}/module_libraries.cpp")
configure_file("${CMAKE_CURRENT_LIST_DIR}/module_libraries.cpp.in" "${AULA_MODULE_SOURCE}" @ONLY)
set(AULA_MODULE_LIBRARIES "${libraries}")

function(aula_module target)
    target_sources(${target} PRIVATE "${AULA_MODULE_SOURCE}")
    target_link_libraries(${target} PRIVATE aula::process)
    add_custom_command(TARGET ${target} POST_BUILD
        COMMAND "${CMAKE_COMMAND}" -E copy_if_different ${AULA_MODULE_LIBRARIES}
                "$<TARGET_FILE:aula_sound_reader>" "$<TARGET_FILE:aula_sofa_reader>"
                "$<TARGET_FILE_DIR:${target}>"
        VERBATIM)
endfunction()
