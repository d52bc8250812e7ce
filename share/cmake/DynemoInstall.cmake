# find_package(dynemo) for other projects.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/dynemo)
install(TARGETS dynemo_options EXPORT dynemoTargets)
set_target_properties(dynemo_options PROPERTIES EXPORT_NAME options)
install(EXPORT dynemoTargets NAMESPACE dynemo:: DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/dynemoConfig.cmake.in
  ${CMAKE_BINARY_DIR}/dynemoConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/dynemoConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/dynemoConfig.cmake ${CMAKE_BINARY_DIR}/dynemoConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/DynemoDependencies.cmake ${CMAKE_CURRENT_LIST_DIR}/DynemoFindPcl.cmake
  ${CMAKE_CURRENT_LIST_DIR}/DynemoFindOpenBLAS.cmake ${CMAKE_CURRENT_LIST_DIR}/DynemoFindRosbag.cmake
  ${CMAKE_CURRENT_LIST_DIR}/DynemoFindSuiteSparse.cmake
  DESTINATION ${package_dir})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/share/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/dynemo)

# What DynemoBuild.cmake runs before anything is installed.
foreach(component programs development)
  get_property(files GLOBAL PROPERTY DYNEMO_INSTALLED_${component})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/DynemoInstallCheck.cmake.in ${CMAKE_BINARY_DIR}/check_${component}.cmake.in @ONLY)
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/check_${component}.cmake INPUT ${CMAKE_BINARY_DIR}/check_${component}.cmake.in)
endforeach()
