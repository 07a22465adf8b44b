# cmake -DSOURCE=.. -DBUILD=.. -DFILES=.. -DWORK=.. -DGENERATOR=.. -DCOMPILER=.. -P first_build.cmake:
# installs from a build folder that contains only FILES of BUILD: those built for the program aula.
file(REMOVE_RECURSE "${WORK}")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run("${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/build" -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" -DAULA_BUILD_TESTS=OFF)
foreach(file IN LISTS FILES)
    file(RELATIVE_PATH relative "${BUILD}" "${file}")
    cmake_path(GET relative PARENT_PATH folder)
    file(COPY "${file}" DESTINATION "${WORK}/build/${folder}")
endforeach()
run("${CMAKE_COMMAND}" --install "${WORK}/build" --prefix "${WORK}/prefix")
run("${WORK}/prefix/bin/aula" --version)
foreach(file LICENSE materials.LICENSE kemar.LICENSE)
    if(NOT EXISTS "${WORK}/prefix/share/doc/aula/${file}")
        message(FATAL_ERROR "${file} was not installed")
    endif()
endforeach()
file(REMOVE_RECURSE "${WORK}")
