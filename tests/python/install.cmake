# cmake -DBUILD=.. -DSOURCE=.. -DWORK=.. -DPYTHON=.. -P install.cmake: installs the package into a
# new virtual environment, without network.
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}/metadata")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()
# Metadata take no build: without a path there is no CMake.
execute_process(COMMAND "${CMAKE_COMMAND}" -E env PATH= "PYTHONPATH=${SOURCE}/apps/python"
                        "${PYTHON}" -B -c "import build_backend, sys
print(build_backend.prepare_metadata_for_build_wheel(sys.argv[1]))" "${WORK}/metadata"
                OUTPUT_VARIABLE info COMMAND_ERROR_IS_FATAL ANY)
string(STRIP "${info}" info)
file(READ "${WORK}/metadata/${info}/METADATA" metadata)
if(NOT metadata MATCHES "Name: aula\n" OR NOT info MATCHES "^aula-[0-9.]+\\.dist-info$")
    message(FATAL_ERROR "${info} has the metadata ${metadata}")
endif()
run("${PYTHON}" -m venv --system-site-packages "${WORK}")
run("${WORK}/bin/pip" install --no-index --no-build-isolation --config-settings
    "build-dir=${BUILD}" "${SOURCE}")
execute_process(COMMAND "${WORK}/bin/python" -c "import aula; print(aula.__file__)"
                WORKING_DIRECTORY "${WORK}" OUTPUT_VARIABLE file COMMAND_ERROR_IS_FATAL ANY)
if(NOT file MATCHES "^${WORK}/")
    message(FATAL_ERROR "import aula takes ${file}")
endif()
file(GLOB licences "${WORK}/lib/python3*/site-packages/aula-*.dist-info/LICENSE"
     "${WORK}/lib/python3*/site-packages/aula-*.dist-info/copyright")
list(LENGTH licences count)
if(NOT count EQUAL 2)
    message(FATAL_ERROR "the wheel has the licences ${licences}")
endif()
# The module exports its entry alone, and needs no device library.
file(GLOB module "${WORK}/lib/python3*/site-packages/aula/_aula.*.so")
execute_process(COMMAND nm -D --defined-only "${module}" OUTPUT_VARIABLE symbols
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND readelf -d "${module}" OUTPUT_VARIABLE needed COMMAND_ERROR_IS_FATAL ANY)
if(NOT symbols MATCHES "PyInit__aula" OR symbols MATCHES "aula5|_ZN4aula|pybind11|H5|embree")
    message(FATAL_ERROR "the module exports ${symbols}")
endif()
if(needed MATCHES "portaudio|jack|asound|libGL|libpython")
    message(FATAL_ERROR "the module needs ${needed}")
endif()
