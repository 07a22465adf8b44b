# Writes the header OUTPUT with the commit of the sources in SOURCE. The file is not touched if
# the commit is the same. A parent folder's repository does not count.
cmake_minimum_required(VERSION 3.25)
cmake_path(GET SOURCE PARENT_PATH parent)
set(ENV{GIT_CEILING_DIRECTORIES} "${parent}")
execute_process(COMMAND git rev-parse --short=12 HEAD WORKING_DIRECTORY "${SOURCE}"
    OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
if(failed)
    set(revision "unknown")
else()
    execute_process(COMMAND git status --porcelain -- engine audio apps cmake CMakeLists.txt
        WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
        string(APPEND revision " with changes")
    endif()
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define AULA_REVISION \"${revision}\"\n" @ONLY)
