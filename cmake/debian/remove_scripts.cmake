# Runs after cpack: removes the scripts that call ldconfig, which CPack adds to packages with shared
# libraries. The trigger of the package updates the linker's cache.
foreach(package IN LISTS CPACK_PACKAGE_FILES)
    set(folder "${CPACK_TEMPORARY_DIRECTORY}/repacked")
    file(REMOVE_RECURSE "${folder}")
    execute_process(COMMAND dpkg-deb --raw-extract "${package}" "${folder}"
                    COMMAND_ERROR_IS_FATAL ANY)
    set(script "")
    if(EXISTS "${folder}/DEBIAN/postinst")
        file(READ "${folder}/DEBIAN/postinst" script)
    endif()
    if(NOT script MATCHES "ldconfig")
        continue()
    endif()
    file(REMOVE "${folder}/DEBIAN/postinst" "${folder}/DEBIAN/postrm")
    execute_process(COMMAND dpkg-deb --root-owner-group --build "${folder}" "${package}"
                    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
file(REMOVE_RECURSE "${folder}")
