# cmake -DBUILD=.. -DCONSUMER=.. -DEXAMPLES=.. -DSCENE=.. -DSOUND=.. -DWORK=.. -DGENERATOR=.. -DCOMPILER=.. -DSANITIZE=..
# -P run.cmake:
# installs Aula, builds the consumer and the examples against what was installed, and runs them.
file(REMOVE_RECURSE "${WORK}")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/prefix")
set(flags "")
if(SANITIZE)
    set(flags "-fsanitize=${SANITIZE}")
endif()
run("${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${WORK}/build" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_FLAGS=${flags}" -DCMAKE_BUILD_TYPE=Release
    "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DEXAMPLES=${EXAMPLES}")
run("${CMAKE_COMMAND}" --build "${WORK}/build")
run("${WORK}/build/render_room" "${SCENE}" "${WORK}/out.wav")
file(SIZE "${WORK}/out.wav" size)
# One second of two channels of 32-bit floats at 48 kHz, and a header.
if(size LESS 384000)
    message(FATAL_ERROR "out.wav has ${size} bytes; expected 384000 and a header")
endif()

# A file: at least a second of two channels.
run("${WORK}/build/render_file" "${SCENE}" "${SOUND}" "${WORK}/file.wav")
file(SIZE "${WORK}/file.wav" size)
if(size LESS 384000)
    message(FATAL_ERROR "file.wav has ${size} bytes")
endif()

# A game's loop: nothing is heard through the shut door, and the noise is when it is open.
execute_process(COMMAND "${WORK}/build/game_loop" OUTPUT_VARIABLE levels COMMAND_ECHO STDOUT
                COMMAND_ERROR_IS_FATAL ANY)
if(NOT levels MATCHES "2.00 s  door   0 % open  level -200.0 dB"
   OR NOT levels MATCHES "4.00 s  door 100 % open  level  -1[0-9].[0-9] dB")
    message(FATAL_ERROR "levels of the game's loop:\n${levels}")
endif()

# An own callback: all its blocks, and sound at both ears.
execute_process(COMMAND "${WORK}/build/own_callback" "${SCENE}" OUTPUT_VARIABLE heard
                COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
if(NOT heard MATCHES "^153600 samples.*left 0.[0-9]*[1-9][0-9]*, right 0.[0-9]*[1-9][0-9]* rms")
    message(FATAL_ERROR "the own callback printed ${heard}")
endif()
file(REMOVE_RECURSE "${WORK}")
