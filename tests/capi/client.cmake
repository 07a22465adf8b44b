# cmake -DCASE=.. -DBUILD=.. -DSOURCE=.. -DWORK=.. -DLIBDIR=.. -DCC=.. -DSANITIZE=.. -DVALGRIND=..
# -DABIDIFF=.. -DMINIAUDIO=.. -P client.cmake: a test of the installed C interface.
set(prefix "${WORK}/prefix")
set(library "${prefix}/${LIBDIR}/libaula.so.0")
set(ENV{LD_LIBRARY_PATH} "${prefix}/${LIBDIR}")
set(ENV{PKG_CONFIG_PATH} "${prefix}/${LIBDIR}/pkgconfig")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# A C99 program WORK/NAME, compiled by the line that docs/c_api.md or the program gives; with
# further libraries.
function(compile name source packages)
    execute_process(COMMAND pkg-config --cflags --libs ${packages} OUTPUT_VARIABLE flags
                    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${flags}")
    if(SANITIZE)
        list(APPEND flags "-fsanitize=${SANITIZE}")
    endif()
    run("${CC}" -std=c99 -Wall -Wextra -pedantic -Werror -g "${source}" ${flags} ${ARGN}
        -o "${WORK}/${name}")
endfunction()

# The largest magnitude of the 32-bit floats in the last `bytes` of a file: half of it, it, twice
# it.
function(find_peak file bytes result)
    execute_process(COMMAND tail -c ${bytes} "${file}" COMMAND od -An -v -t f4 -w4
                    COMMAND awk "{x = $1 < 0 ? -$1 : $1; if (x > m) m = x}
                                 END {printf \"%.4f;%.4f;%.4f\", m / 2, m, 2 * m}"
                    OUTPUT_VARIABLE peaks COMMAND_ERROR_IS_FATAL ANY)
    set(${result} "${peaks}" PARENT_SCOPE)
endfunction()

# Runs apps/examples/NAME.c, and checks its line and its errors. PEAK: the level that it says it has
# played. It is that of `aula --offline`, within 6 dB; by the distances of the walk, within 2 dB.
function(walk name)
    set(sound "${SOURCE}/scenes/sounds/speech_man.wav")
    file(WRITE "${WORK}/walk.json" "{\"aula\": 1,
        \"geometry\": [{\"box\": [6, 5, 3], \"material\": \"brick\"}],
        \"sources\": [{\"position\": [2, 2, 1.5], \"signal\": \"${sound}\", \"loop\": true,
                       \"gain_db\": -12}],
        \"listener\": {\"position\": [4.5, 3, 1.7], \"yaw_deg\": 90},
        \"simulation\": {\"rays\": 100, \"ir_length_s\": 0.5}}")
    run("${prefix}/bin/aula" "${WORK}/walk.json" --offline "${WORK}/offline.wav" --duration 6)
    find_peak("${WORK}/offline.wav" 2304000 limits)  # 6 s of 2 channels at 48 kHz
    list(GET limits 0 low)
    list(GET limits 2 high)
    execute_process(COMMAND "${WORK}/${name}" walk.json "${sound}" 4 3 1.7
                    WORKING_DIRECTORY "${WORK}" COMMAND_ECHO STDOUT OUTPUT_VARIABLE printed
                    COMMAND_ERROR_IS_FATAL ANY)
    message(STATUS "${printed}")
    if(NOT printed MATCHES
       "^[1-9]\\.[0-9] s, peak ([0-9.]+); [1-9][0-9]* propagation frames, [0-9]+ of them late\n$"
       OR CMAKE_MATCH_1 LESS low OR CMAKE_MATCH_1 GREATER high)
        message(FATAL_ERROR "expected a peak of ${low} to ${high}: ${printed}")
    endif()
    set(PEAK ${CMAKE_MATCH_1} PARENT_SCOPE)
    execute_process(COMMAND "${WORK}/${name}" nowhere.json "${sound}" 4 3 1.7
                    RESULT_VARIABLE status ERROR_VARIABLE message)
    if(NOT status EQUAL 2 OR NOT message MATCHES "${name}: nowhere.json: no such file[^\n]*\n$")
        message(FATAL_ERROR "no scene: ${status}, ${message}")
    endif()
endfunction()

if(CASE STREQUAL "compile")
    file(REMOVE_RECURSE "${WORK}")
    run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${prefix}")
    compile(moving_source "${SOURCE}/apps/examples/moving_source.c" "aula;portaudio-2.0")
    file(READ "${SOURCE}/docs/c_api.md" page)
    if(NOT page MATCHES "```c\n(#include <aula.h>.*return 0;\n}\n)```")
        message(FATAL_ERROR "no program in docs/c_api.md")
    endif()
    file(WRITE "${WORK}/page.c" "${CMAKE_MATCH_1}")
    compile(page "${WORK}/page.c" aula)
    execute_process(COMMAND pkg-config --modversion aula OUTPUT_VARIABLE version
                    OUTPUT_STRIP_TRAILING_WHITESPACE)
    execute_process(COMMAND "${WORK}/page" OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
    if(NOT printed MATCHES "^Aula ${version}: energy [0-9]+\\.[0-9]+ at"
       OR printed MATCHES " 0.0000 ")
        message(FATAL_ERROR "the program of docs/c_api.md printed ${printed}")
    endif()

elseif(CASE STREQUAL "exports")
    execute_process(COMMAND nm -D --defined-only --without-symbol-versions "${library}"
                    OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "[^ \n]+\n" names "${symbols}")
    list(FILTER names EXCLUDE REGEX "^AULA_0\n")
    list(TRANSFORM names STRIP)
    file(READ "${prefix}/include/aula.h" header)
    string(REGEX MATCHALL "\nAULA_API [^(]*" declared "${header}")
    list(TRANSFORM declared REPLACE ".*[ *]" "")
    list(SORT names)
    list(SORT declared)
    if(NOT names STREQUAL declared)
        message(FATAL_ERROR "exported: ${names}\nin aula.h: ${declared}")
    endif()
    execute_process(COMMAND readelf -d "${library}" OUTPUT_VARIABLE dynamic
                    COMMAND_ERROR_IS_FATAL ANY)
    if(NOT dynamic MATCHES "soname: \\[libaula.so.0\\]")
        message(FATAL_ERROR "the soname is not libaula.so.0")
    endif()
    if(NOT dynamic MATCHES "NODELETE")
        message(FATAL_ERROR "libaula.so.0 can be unloaded while threads of its libraries run")
    endif()
    if(dynamic MATCHES "NEEDED[^\n]*(portaudio|jack|asound|liblo|libGL|glfw|RPATH|RUNPATH)")
        message(FATAL_ERROR "libaula.so.0 needs ${CMAKE_MATCH_1}")
    endif()

elseif(CASE STREQUAL "exact")
    # All numbers of the movement are exact in single precision.
    file(WRITE "${WORK}/scene.json" [[
        {"aula": 1,
         "geometry": [{"box": [10, 8, 4], "material": "brick"}],
         "sources": [{"name": "clicks", "position": [2, 2, 1.5], "signal": "impulse", "loop": true,
           "path": {"points": [{"t": 0, "position": [2, 2, 1.5]}, {"t": 4, "position": [6, 2, 1.5]}]}}],
         "listener": {"position": [5, 5, 1.7], "yaw_deg": 180},
         "simulation": {"rays": 100, "frame_rate_hz": 32, "ir_length_s": 0.5}}]])
    run("${WORK}/moving_source" "${WORK}/scene.json" clicks "${WORK}/c.f32")
    run("${prefix}/bin/aula" "${WORK}/scene.json" --offline "${WORK}/offline.wav" --duration 4)
    file(SIZE "${WORK}/offline.wav" wav)
    file(SIZE "${WORK}/c.f32" samples)
    if(NOT samples EQUAL 1536000)
        message(FATAL_ERROR "c.f32 has ${samples} bytes; expected 4 s of 2 channels of 48 kHz")
    endif()
    # The samples are the end of the WAV file.
    math(EXPR header "${wav} - ${samples}")
    run(cmp -i "${header}:0" "${WORK}/offline.wav" "${WORK}/c.f32")
    # Another movement gives other samples.
    file(READ "${WORK}/scene.json" scene)
    string(REPLACE "[6, 2, 1.5]" "[6, 2.01, 1.5]" scene "${scene}")
    file(WRITE "${WORK}/scene.json" "${scene}")
    run("${prefix}/bin/aula" "${WORK}/scene.json" --offline "${WORK}/offline.wav" --duration 4)
    execute_process(COMMAND cmp -s -i "${header}:0" "${WORK}/offline.wav" "${WORK}/c.f32"
                    RESULT_VARIABLE same)
    if(same EQUAL 0)
        message(FATAL_ERROR "the comparison accepts another movement")
    endif()

elseif(CASE STREQUAL "live")
    if(SANITIZE)
        message(STATUS "skipped: PortAudio leaks")
        return()
    endif()
    file(WRITE "${WORK}/asound.conf" "pcm.!default { type null }\nctl.!default { type null }\n")
    # A relative path, because ALSA divides a list at blanks.
    set(ENV{ALSA_CONFIG_PATH} asound.conf)
    set(ENV{JACK_NO_START_SERVER} 1)
    run("${WORK}/moving_source" "${SOURCE}/scenes/shoebox.json" castanets
        WORKING_DIRECTORY "${WORK}")
    execute_process(COMMAND "${WORK}/moving_source" "${SOURCE}/scenes/shoebox.json" nobody
                    WORKING_DIRECTORY "${WORK}"
                    RESULT_VARIABLE status ERROR_VARIABLE message)
    if(NOT status EQUAL 2 OR NOT message MATCHES "no source \"nobody\"")
        message(FATAL_ERROR "an unknown source: ${status}, ${message}")
    endif()

elseif(CASE STREQUAL "sdl3")
    execute_process(COMMAND pkg-config --exists sdl3 RESULT_VARIABLE missing)
    if(missing)
        message(STATUS "skipped: SDL 3 is missing (libsdl3-dev of Debian 13)")
        return()
    endif()
    compile(sdl3_walk "${SOURCE}/apps/examples/sdl3_walk.c" "aula;sdl3" -lm)
    set(ENV{SDL_AUDIO_DRIVER} disk)
    set(ENV{SDL_AUDIO_DISK_OUTPUT_FILE} "${WORK}/sdl3.raw")
    walk(sdl3_walk)
    file(SIZE "${WORK}/sdl3.raw" bytes)
    find_peak("${WORK}/sdl3.raw" ${bytes} played)
    list(GET played 1 played)
    if(NOT played EQUAL PEAK)
        message(FATAL_ERROR "the device received a peak of ${played}")
    endif()

elseif(CASE STREQUAL "miniaudio")
    if(NOT MINIAUDIO)
        message(STATUS "skipped: miniaudio.h is missing (libminiaudio-dev of Debian 13)")
        return()
    endif()
    compile(miniaudio_walk "${SOURCE}/apps/examples/miniaudio_walk.c" aula -lm -lpthread -ldl)
    # No server and no device: miniaudio plays to its null device, in real time.
    file(WRITE "${WORK}/no_device.conf" "")
    set(ENV{ALSA_CONFIG_PATH} no_device.conf)
    set(ENV{JACK_NO_START_SERVER} 1)
    set(ENV{JACK_DEFAULT_SERVER} none)
    set(ENV{PULSE_SERVER} none)
    walk(miniaudio_walk)

elseif(CASE STREQUAL "valgrind")
    if(SANITIZE OR NOT VALGRIND)
        message(STATUS "skipped: valgrind is missing (packages-test.txt), or sanitizers do its work")
        return()
    endif()
    # Valgrind takes 100 times as long: few rays and samples, and walls that leave few modes.
    file(READ "${WORK}/page.c" program)
    string(REPLACE "\"brick\"" "\"mineral_wool\"" program "${program}")
    string(REPLACE ".max_sources = 1"
           ".max_sources = 1, .rays = 20, .ir_length_s = 0.05, .threads = 1, .sample_rate_hz = 8000"
           program "${program}")
    file(WRITE "${WORK}/few_rays.c" "${program}")
    compile(few_rays "${WORK}/few_rays.c" aula)
    run("${VALGRIND}" --quiet --error-exitcode=9 --leak-check=full
        --errors-for-leak-kinds=definite "--suppressions=${SOURCE}/tests/capi/valgrind.supp"
        "${WORK}/few_rays")

elseif(CASE STREQUAL "abi")
    if(SANITIZE OR NOT ABIDIFF)
        message(STATUS "skipped: abidiff is missing (packages-test.txt), or the build is for tests")
        return()
    endif()
    run("${CC}" -g -shared -fPIC -Wl,-soname,libaula.so.0
        "-Wl,--version-script=${SOURCE}/apps/capi/aula.map" "${SOURCE}/tests/capi/abi_0.c"
        -o "${WORK}/libaula_0.so")
    set(compare "${ABIDIFF}" --drop-private-types --headers-dir1 "${SOURCE}/tests/capi"
                --headers-dir2 "${prefix}/include" "${WORK}/libaula_0.so")
    run(${compare} "${library}")
    # The comparison finds a change.
    file(READ "${SOURCE}/tests/capi/abi_0.c" text)
    string(REPLACE "float gain_db" "double gain_db" text "${text}")
    file(WRITE "${WORK}/changed.c" "${text}")
    run("${CC}" -g -shared -fPIC -Wl,-soname,libaula.so.0
        "-Wl,--version-script=${SOURCE}/apps/capi/aula.map" "${WORK}/changed.c"
        -o "${WORK}/libchanged.so")
    execute_process(COMMAND ${compare} "${WORK}/libchanged.so" RESULT_VARIABLE status
                    OUTPUT_QUIET)
    if(status EQUAL 0)
        message(FATAL_ERROR "the comparison accepts another type of an argument")
    endif()
endif()
