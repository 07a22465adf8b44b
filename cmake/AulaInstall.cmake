include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/aula")
install(EXPORT aula NAMESPACE aula:: FILE aulaTargets.cmake DESTINATION "${package_dir}")
file(WRITE "${PROJECT_BINARY_DIR}/aulaConfig.cmake" [=[
include("${CMAKE_CURRENT_LIST_DIR}/AulaDependencies.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/aulaTargets.cmake")
]=])
write_basic_package_version_file("${PROJECT_BINARY_DIR}/aulaConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/aulaConfig.cmake" "${PROJECT_BINARY_DIR}/aulaConfigVersion.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/AulaDependencies.cmake" DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
