# cmake -D INPUT=aula.h -D OUTPUT=FOLDER -D VERSION=.. -P HeaderManual.cmake: the manual page aula.3
# of a C header, and a page for each function that refers to it, compressed. Descriptions are the
# header's comments.
cmake_minimum_required(VERSION 3.25)
file(READ "${INPUT}" header)
file(REMOVE_RECURSE "${OUTPUT}")

# The text of a comment, without its delimiters, for roff. Indented lines are code.
function(to_roff comment result)
    string(REGEX REPLACE "^ *[/][*] *" "" text "${comment}")
    string(REGEX REPLACE " *[*][/] *$" "" text "${text}")
    string(REPLACE "\\" "\\e" text "${text}")
    string(REGEX REPLACE "\n *[*] *\n" "\n.PP\n" text "${text}")
    string(REGEX REPLACE "\n [*]     ( *)([^\n]+)" "\n.br\n\\\\ \\\\ \\\\ \\1\\2" text "${text}")
    string(REGEX REPLACE "\n [*] " "\n" text "${text}")
    set(${result} "${text}" PARENT_SCOPE)
endfunction()

# The comment at the beginning.
string(FIND "${header}" "/*" begin)
string(FIND "${header}" "*/" end)
math(EXPR size "${end} + 2 - ${begin}")
string(SUBSTRING "${header}" ${begin} ${size} comment)
to_roff("${comment}" description)

# The types and constants: from the first enumeration to the comment of the first function.
string(FIND "${header}" "\nenum {" begin)
string(FIND "${header}" "\nAULA_API " first)
string(SUBSTRING "${header}" 0 ${first} before)
string(FIND "${before}" "/*" end REVERSE)
math(EXPR size "${end} - ${begin}")
string(SUBSTRING "${header}" ${begin} ${size} types)
string(REPLACE "\\" "\\e" types "${types}")

set(names aula)
set(functions "")
string(SUBSTRING "${header}" ${end} -1 rest)
while(TRUE)
    string(FIND "${rest}" "\nAULA_API " at)
    if(at EQUAL -1)
        break()
    endif()
    string(SUBSTRING "${rest}" 0 ${at} comment)
    string(FIND "${comment}" "/*" begin REVERSE)
    if(begin EQUAL -1)
        message(FATAL_ERROR "${INPUT}: a function without a comment")
    endif()
    string(SUBSTRING "${comment}" ${begin} -1 comment)
    to_roff("${comment}" comment)
    math(EXPR at "${at} + 10")
    string(SUBSTRING "${rest}" ${at} -1 rest)
    string(FIND "${rest}" ";" end)
    string(SUBSTRING "${rest}" 0 ${end} declaration)
    string(SUBSTRING "${rest}" ${end} -1 rest)
    string(REGEX MATCH "(aula_[a-z_]+)\\(" found "${declaration}")
    set(name "${CMAKE_MATCH_1}")
    string(APPEND functions ".SS ${name}\n.nf\n.B ")
    string(REGEX REPLACE "\n *" "\n.B \\\\ \\\\ \\\\ \\\\ " declaration "${declaration}")
    string(APPEND functions "${declaration};\n.fi\n.PP\n${comment}\n")
    list(APPEND names "${name}")
endwhile()
list(JOIN names ", " all)

file(WRITE "${OUTPUT}/aula.3" ".TH AULA 3 \"\" \"Aula ${VERSION}\" \"Aula\"
.SH NAME
${all} \\- room acoustics in real time
.SH SYNOPSIS
.nf
.B #include <aula.h>
.PP
cc \\-std=c99 program.c $(pkg\\-config \\-\\-cflags \\-\\-libs aula)
.fi
.SH DESCRIPTION
${description}
.SH TYPES AND CONSTANTS
.nf${types}.fi
.SH FUNCTIONS
${functions}.SH SEE ALSO
.BR aula (1)
")
list(REMOVE_AT names 0)
foreach(name IN LISTS names)
    file(WRITE "${OUTPUT}/${name}.3" ".so man3/aula.3\n")
endforeach()
file(GLOB pages "${OUTPUT}/*.3")
execute_process(COMMAND gzip -9 -n ${pages} COMMAND_ERROR_IS_FATAL ANY)
