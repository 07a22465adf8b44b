# aula_optional(OPTION FOUND PART MISSING): an option, on by default, for a part of the project that
# needs what may be missing. Without what it needs, or without the option, the calling list file
# ends: FOUND is the name of a variable that is false, and MISSING says what and in which package.
macro(aula_optional option found part missing)
    if(NOT ${found})
        if(${option})
            message(FATAL_ERROR "${option} is on, but ${missing}")
        endif()
        message(STATUS "Without ${part}: ${missing}")
        return()
    endif()
    option(${option} "Build ${part}" ON)
    if(NOT ${option})
        message(STATUS "Without ${part}: ${option} is off")
        return()
    endif()
endmacro()
