include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/aula")
foreach(component exception c engine audio room devices)
    install(EXPORT aula-${component} NAMESPACE aula:: FILE aula-${component}.cmake
            DESTINATION "${package_dir}")
endforeach()
write_basic_package_version_file("${PROJECT_BINARY_DIR}/aulaConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
configure_file(cmake/aulaConfig.cmake.in aulaConfig.cmake @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/aulaConfig.cmake"
              "${PROJECT_BINARY_DIR}/aulaConfigVersion.cmake" cmake/AulaDependencies.cmake
        DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}"
        COMPONENT license)
