# cmake -DCASE=.. -DBUILD=.. -DSOURCE=.. -DWORK=.. -DCC=.. -DLINTIAN=.. -DPYTHON=.. -P
# run.cmake: a test of the Debian packages. PYTHON is empty without python3-aula.
set(ENV{LC_ALL} C.UTF-8)
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()
file(GLOB packages "${WORK}/packages/*.deb")

if(CASE STREQUAL "build")
    file(REMOVE_RECURSE "${WORK}")
    run(cpack -G DEB --config "${BUILD}/CPackConfig.cmake" -B "${WORK}/packages")
    file(GLOB packages "${WORK}/packages/*.deb")
    set(names aula libaula0 libaula-dev)
    if(PYTHON)
        list(APPEND names python3-aula)
    endif()
    foreach(name IN LISTS names)
        if(NOT packages MATCHES "/${name}_")
            message(FATAL_ERROR "no package ${name} in ${packages}")
        endif()
    endforeach()
    # The libraries of the programs that are embedded in the binaries.
    foreach(package IN LISTS packages)
        execute_process(COMMAND dpkg-deb --field "${package}" Package Depends
                        OUTPUT_VARIABLE fields COMMAND_ERROR_IS_FATAL ANY)
        if(NOT fields MATCHES "Package: libaula-dev" AND
           NOT (fields MATCHES "libmysofa1" AND fields MATCHES "libsndfile1" AND
                fields MATCHES "libsz2|libhdf5"))
            message(FATAL_ERROR "${package} lacks a library of its readers: ${fields}")
        endif()
    endforeach()
    # Those that the program loads to play.
    file(GLOB program "${WORK}/packages/aula_*.deb")
    execute_process(COMMAND dpkg-deb --field "${program}" Depends Recommends
                    OUTPUT_VARIABLE fields COMMAND_ERROR_IS_FATAL ANY)
    if(NOT fields MATCHES "Recommends: libjack[^\n]*, libasound2" OR
       fields MATCHES "Depends: [^\n]*(libjack|libasound|libglfw|libgl1)")
        message(FATAL_ERROR "${program}: ${fields}")
    endif()
    # Nothing outside the prefix.
    foreach(package IN LISTS packages)
        execute_process(COMMAND dpkg-deb --contents "${package}" OUTPUT_VARIABLE contents
                        COMMAND_ERROR_IS_FATAL ANY)
        if(contents MATCHES "[^\n]* \\./(usr/local|[^u/\n]|u[^s\n])[^\n]*")
            message(FATAL_ERROR "${package} installs ${CMAKE_MATCH_0}")
        endif()
    endforeach()

elseif(CASE STREQUAL "lintian")
    if(NOT LINTIAN)
        message(STATUS "skipped: lintian is missing (packages-test.txt)")
        return()
    endif()
    run("${LINTIAN}" --allow-root --fail-on error ${packages})

elseif(CASE STREQUAL "use")
    set(root "${WORK}/root")
    foreach(folder info updates triggers)
        file(MAKE_DIRECTORY "${root}/var/lib/dpkg/${folder}")
    endforeach()
    file(WRITE "${root}/var/lib/dpkg/status" "")
    # The root has no shell for scripts of packages: they run outside it, with DPKG_ROOT.
    set(dpkg dpkg --root=${root} --force-not-root --force-depends --force-script-chrootless
             --log=${WORK}/dpkg.log)
    execute_process(COMMAND fakeroot --version RESULT_VARIABLE status OUTPUT_QUIET)
    if(NOT status EQUAL 0)
        message(STATUS "skipped: fakeroot is missing (packages-test.txt)")
        return()
    endif()
    run(fakeroot ${dpkg} --install ${packages})

    # The program finds its scenes from any folder.
    file(MAKE_DIRECTORY "${WORK}/elsewhere")
    execute_process(COMMAND "${root}/usr/bin/aula" check two_rooms
                    WORKING_DIRECTORY "${WORK}/elsewhere" OUTPUT_VARIABLE checked
                    COMMAND_ERROR_IS_FATAL ANY)
    if(NOT checked MATCHES "${root}/usr/share/aula/scenes/two_rooms.json: ok")
        message(FATAL_ERROR "aula check two_rooms printed ${checked}")
    endif()
    execute_process(COMMAND "${root}/usr/bin/aula" shoebox --offline "${WORK}/out.wav"
                            --duration 0.1 --rays 10
                    WORKING_DIRECTORY "${WORK}/elsewhere" COMMAND_ERROR_IS_FATAL ANY)
    execute_process(COMMAND "${root}/usr/bin/aula" check no_such_scene
                    RESULT_VARIABLE status ERROR_VARIABLE message)
    if(NOT status EQUAL 2 OR NOT message MATCHES "${root}/usr/share/aula/scenes")
        message(FATAL_ERROR "an unknown scene: ${status}, ${message}")
    endif()

    # The interpreter of the distribution finds the package, and writes its byte code.
    if(PYTHON)
        unset(ENV{PYTHONDONTWRITEBYTECODE})
        set(ENV{PYTHONPATH} "${root}/usr/lib/python3/dist-packages")
        execute_process(COMMAND "${PYTHON}" -c "
import aula
room = aula.Scene.shoebox((6, 5, 3), material='plaster')
h = aula.rir(room, sources=(1, 1, 1), microphones=(4, 3, 1), frames=1, rays=10, length_s=.05)
print(aula.__file__, h.shape[:3], aula.__version__)"
                        WORKING_DIRECTORY "${WORK}/elsewhere" OUTPUT_VARIABLE printed
                        COMMAND_ERROR_IS_FATAL ANY)
        unset(ENV{PYTHONPATH})
        file(GLOB byte_code "${root}/usr/lib/python3/dist-packages/aula/__pycache__/*.pyc")
        if(NOT printed MATCHES "^${root}/usr/lib/python3/dist-packages/aula/.*\\(1, 1, 1\\)"
           OR NOT byte_code)
            message(FATAL_ERROR "import aula printed ${printed}, and wrote ${byte_code}")
        endif()
    endif()

    # A C99 program compiles, links and runs.
    set(ENV{PKG_CONFIG_PATH} "${root}/usr/lib/pkgconfig")
    set(ENV{LD_LIBRARY_PATH} "${root}/usr/lib")
    execute_process(COMMAND pkg-config --cflags --libs aula OUTPUT_VARIABLE flags
                    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${flags}")
    file(WRITE "${WORK}/client.c"
         "#include <aula.h>\n#include <stdio.h>\nint main(void) { return puts(aula_version()) < 0; }\n")
    run("${CC}" -std=c99 -Wall -Werror "${WORK}/client.c" ${flags} -o "${WORK}/client")
    run("${WORK}/client")

    # Each function of the header has a manual page without a warning.
    file(STRINGS "${root}/usr/include/aula.h" declarations REGEX "^AULA_API ")
    foreach(declaration IN LISTS declarations)
        string(REGEX MATCH "(aula_[a-z_]+)\\(" found "${declaration}")
        if(NOT EXISTS "${root}/usr/share/man/man3/${CMAKE_MATCH_1}.3.gz")
            message(FATAL_ERROR "no manual page of ${CMAKE_MATCH_1}")
        endif()
    endforeach()
    find_program(MAN man)
    if(MAN)
        set(ENV{MANWIDTH} 100)
        execute_process(COMMAND "${MAN}" --warnings --local-file
                                "${root}/usr/share/man/man3/aula.3.gz"
                        OUTPUT_VARIABLE manual ERROR_VARIABLE warnings COMMAND_ERROR_IS_FATAL ANY)
        if(NOT warnings STREQUAL "" OR NOT manual MATCHES "aula_room_process_exactly")
            message(FATAL_ERROR "aula.3: ${warnings}")
        endif()
    endif()

    execute_process(COMMAND dpkg-query --root=${root} -W -f "\${Package} "
                    OUTPUT_VARIABLE names COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(names)
    run(fakeroot ${dpkg} --purge ${names})
    file(GLOB left "${root}/*")
    list(REMOVE_ITEM left "${root}/var")
    if(left)
        file(GLOB_RECURSE left "${root}/usr/*")
        message(FATAL_ERROR "left behind: ${left}")
    endif()
endif()
