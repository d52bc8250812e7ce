# cpack in the build folder makes two Debian packages: the programs, and what other projects build against.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dynemo-slam RENAME copyright
  COMPONENT programs)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libdynemo-dev RENAME copyright
  COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dynemo-slam COMPONENT programs)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/share/doc/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dynemo-slam
  COMPONENT programs FILES_MATCHING PATTERN "*.md" PATTERN "*.png")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME dynemo-slam)
set(CPACK_PACKAGE_VENDOR "DYNEMO-SLAM")
set(CPACK_PACKAGE_CONTACT "The DYNEMO-SLAM developers <dynemo-slam@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME dynemo-slam)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "mrpt-apps, gnuplot-nox")
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION
  "Simultaneous localisation and mapping from MRPT rawlogs of LiDAR, camera and\nodometry in places with moving agents and objects, as a dynamic 3D scene graph.")

# What find_package(dynemo) needs: the libraries of install-dependencies.sh.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libdynemo-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
execute_process(COMMAND ${PROJECT_SOURCE_DIR}/share/scripts/install-dependencies.sh --list-libraries
  OUTPUT_VARIABLE CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS}")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers and static libraries of DYNEMO-SLAM for other CMake projects.")
include(CPack)
