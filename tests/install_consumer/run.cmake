# cmake -DBUILD=.. -DCONSUMER=.. -DSOURCE=.. -DSCENE=.. -DSOUND=.. -DWORK=.. -DGENERATOR=.. -DCOMPILER=.. -DSANITIZE=..
# -P run.cmake:
# installs Aula, builds the consumer of each component, the examples and the programs of the
# documents against what was installed, and runs them.
file(REMOVE_RECURSE "${WORK}")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/prefix")
set(flags "")
if(SANITIZE)
    set(flags "-fsanitize=${SANITIZE}")
endif()
function(build component)
    run("${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${WORK}/${component}" -G "${GENERATOR}"
        "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_FLAGS=${flags}" -DCMAKE_BUILD_TYPE=Release
        "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DSOURCE=${SOURCE}" "-DCOMPONENT=${component}")
    run("${CMAKE_COMMAND}" --build "${WORK}/${component}")
    # Only the component's libraries: a sound file is read by audio, a device by devices.
    set(foreign_c "libportaudio|libjack|libasound|liblo|libembree")
    set(foreign_engine "libportaudio|libjack|libasound|liblo|libsndfile|libsoxr")
    set(foreign_audio "libportaudio|libjack|libasound|liblo|libembree")
    set(foreign_room "libportaudio|libjack|libasound|liblo")
    set(foreign_devices "libglfw|libGL|libportaudio|libjack|libasound")
    set(examples_room render_file game_loop own_callback)
    foreach(program use_${component} ${examples_${component}})
        execute_process(COMMAND readelf -d "${WORK}/${component}/${program}"
                        OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
        if(dynamic MATCHES "${foreign_${component}}")
            message(FATAL_ERROR "${program} needs ${CMAKE_MATCH_0}")
        endif()
    endforeach()
    run("${WORK}/${component}/use_${component}" "${SCENE}")
endfunction()
foreach(component c engine audio room devices)
    build(${component})
endforeach()

# A file: two channels of 32-bit floats at 48 kHz, at least a second, with reverberation half a
# second after the onset of the sound.
run("${WORK}/room/render_file" "${SCENE}" "${SOUND}" "${WORK}/file.wav")
file(SIZE "${WORK}/file.wav" size)
file(READ "${WORK}/file.wav" later OFFSET 192000 LIMIT 4000 HEX)
if(size LESS 384000 OR later MATCHES "^0*$")
    message(FATAL_ERROR "file.wav has ${size} bytes, half a second later ${later}")
endif()

# The first program of docs/api.md: two channels of 96000 floats, with reverberation at the end.
execute_process(COMMAND "${WORK}/room/render_page" WORKING_DIRECTORY "${WORK}" COMMAND_ECHO STDOUT
                COMMAND_ERROR_IS_FATAL ANY)
file(SIZE "${WORK}/room.wav" size)
file(READ "${WORK}/room.wav" end OFFSET 764000 HEX)
if(size LESS 768000 OR size GREATER 769000 OR end MATCHES "^0*$")
    message(FATAL_ERROR "room.wav has ${size} bytes, the last ${end}")
endif()

# The program of docs/room_measurements.md: the decay time of the default scene at the second seat.
execute_process(COMMAND "${WORK}/room/measure_page" "${SOURCE}/scenes/default.json"
                OUTPUT_VARIABLE printed COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
if(NOT printed MATCHES "T30 at 1 kHz 0.[0-9]+ s, standard error 0.00[0-9]+ s; [0-9]+ samples")
    message(FATAL_ERROR "the program of docs/room_measurements.md printed ${printed}")
endif()

# A game's loop: silent behind the shut door, noise behind the open one.
execute_process(COMMAND "${WORK}/room/game_loop" OUTPUT_VARIABLE levels COMMAND_ECHO STDOUT
                COMMAND_ERROR_IS_FATAL ANY)
if(NOT levels MATCHES "2.00 s  door   0 % open  level -200.0 dB"
   OR NOT levels MATCHES "4.00 s  door 100 % open  level  -1[0-9].[0-9] dB")
    message(FATAL_ERROR "levels of the game's loop:\n${levels}")
endif()

# An audio callback: all blocks, and sound at both ears.
execute_process(COMMAND "${WORK}/room/own_callback" "${SCENE}" OUTPUT_VARIABLE printed
                COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
if(NOT printed MATCHES "^153600 samples.*left 0.[0-9]*[1-9][0-9]*, right 0.[0-9]*[1-9][0-9]* rms")
    message(FATAL_ERROR "the own callback printed ${printed}")
endif()

# The error for an unknown component names it.
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${WORK}/none"
                        "-DCMAKE_PREFIX_PATH=${WORK}/prefix" -DCOMPONENT=sounds
                RESULT_VARIABLE status ERROR_VARIABLE message OUTPUT_QUIET)
if(status EQUAL 0 OR NOT message MATCHES "no component sounds")
    message(FATAL_ERROR "an unknown component: ${message}")
endif()
file(REMOVE_RECURSE "${WORK}")
