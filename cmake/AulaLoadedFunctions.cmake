# aula_loaded_functions(SOURCES NAME LIBRARY PREFIX): appends to SOURCES a file with all functions
# PREFIX* that the shared library exports, and with aula::load_NAME(). It loads the library and
# returns its handle, or null if there is none; before that none of the functions may be called. A
# program that contains them starts without the library.
function(aula_loaded_functions sources name library prefix)
    file(REAL_PATH "${library}" library)
    execute_process(COMMAND "${CMAKE_OBJDUMP}" -p "${library}" OUTPUT_VARIABLE properties
                    COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCH "SONAME +([^ \n]+)" found "${properties}")
    set(soname "${CMAKE_MATCH_1}")
    execute_process(COMMAND "${CMAKE_NM}" -D --defined-only "${library}" OUTPUT_VARIABLE symbols
                    COMMAND_ERROR_IS_FATAL ANY)
    # Of several versions of a function the default one.
    string(REGEX MATCHALL " T ${prefix}[A-Za-z0-9_]*(@@[^\n]*)?\n" symbols "${symbols}")
    set(names "")
    set(jumps "")
    set(count 0)
    foreach(symbol IN LISTS symbols)
        string(REGEX MATCH "${prefix}[A-Za-z0-9_]*" function "${symbol}")
        math(EXPR offset "${count} * 8")
        math(EXPR count "${count} + 1")
        string(APPEND names "    \"${function}\",\n")
        string(APPEND jumps "AULA_FUNCTION(${function}, ${offset});\n")
    endforeach()
    if(count EQUAL 0)
        message(FATAL_ERROR "${library} exports no function ${prefix}*")
    endif()
    set(file "${CMAKE_CURRENT_BINARY_DIR}/${name}_functions.cpp")
    configure_file("${PROJECT_SOURCE_DIR}/cmake/loaded_functions.cpp.in" "${file}" @ONLY)
    set(${sources} ${${sources}} "${file}" PARENT_SCOPE)
endfunction()
