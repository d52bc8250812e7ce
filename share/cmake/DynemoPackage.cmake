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
# Who builds packages for others names himself, here or as Debian's own tools ask for; else the address says that it is
# none (RFC 2606).
set(DYNEMO_MAINTAINER "" CACHE STRING "Maintainer of the Debian packages, as NAME <ADDRESS>")
set(maintainer "$ENV{DEBFULLNAME}")
if(maintainer STREQUAL "")
  set(maintainer "DYNEMO-SLAM maintainers")
endif()
if(DYNEMO_MAINTAINER)
  set(CPACK_PACKAGE_CONTACT "${DYNEMO_MAINTAINER}")
elseif("$ENV{DEBEMAIL}" MATCHES "<.+>")
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBEMAIL}")
elseif("$ENV{DEBEMAIL}" STREQUAL "")
  set(CPACK_PACKAGE_CONTACT "${maintainer} <maintainers@dynemo-slam.invalid>")
else()
  set(CPACK_PACKAGE_CONTACT "${maintainer} <$ENV{DEBEMAIL}>")
endif()
if(NOT CPACK_PACKAGE_CONTACT MATCHES "^[^<>]+ <[^<>@ ]+@[^<>@ ]+\\.[^<>@ ]+>$")
  message(WARNING "DYNEMO_MAINTAINER (or DEBFULLNAME and DEBEMAIL): '${CPACK_PACKAGE_CONTACT}' is not NAME <ADDRESS>: "
    "lintian will call it an error")
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
# Debian wants a changelog in each package; what changed is in the history of this repository.
execute_process(COMMAND git log -1 --format=%cD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
  OUTPUT_VARIABLE release_date OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT release_date)
  set(release_date "Thu, 01 Jan 1970 00:00:00 +0000")
endif()
set(changelog ${CMAKE_BINARY_DIR}/share/changelog.Debian)
file(CONFIGURE OUTPUT ${changelog} CONTENT "dynemo-slam (@PROJECT_VERSION@-1) unstable; urgency=medium

  * Release @PROJECT_VERSION@.

 -- @CPACK_PACKAGE_CONTACT@  @release_date@
" @ONLY)
if(GZIP)
  execute_process(COMMAND ${GZIP} -9nf ${changelog} COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${changelog}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dynemo-slam COMPONENT programs)
  install(FILES ${changelog}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libdynemo-dev COMPONENT development)
endif()
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
# Pictures are rendered by Mesa, which is loaded when it is needed.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "libegl-mesa0, libgl1-mesa-dri, gnuplot-nox, mrpt-apps")
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
