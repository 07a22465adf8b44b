# cmake -DBUILD=.. -DCONSUMER=.. -DSCENE=.. -DWORK=.. -DGENERATOR=.. -DCOMPILER=.. -DSANITIZE=..
# -P run.cmake:
# installs Aula, builds the consumer against what was installed, renders a scene with it.
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
    "-DCMAKE_PREFIX_PATH=${WORK}/prefix")
run("${CMAKE_COMMAND}" --build "${WORK}/build")
run("${WORK}/build/render_room" "${SCENE}" "${WORK}/out.wav")
file(SIZE "${WORK}/out.wav" size)
# One second of two channels of 32-bit floats at 48 kHz, and a header.
if(size LESS 384000)
    message(FATAL_ERROR "out.wav has ${size} bytes; expected 384000 and a header")
endif()
file(REMOVE_RECURSE "${WORK}")
