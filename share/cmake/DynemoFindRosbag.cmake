# Debian's rosbag storage library, whose CMake packages need catkin: target ROS::rosbag_storage.
find_path(ROSBAG_INCLUDE_DIR rosbag/bag.h REQUIRED)
set(ROSBAG_INCLUDE_DIRS ${ROSBAG_INCLUDE_DIR})
# Its headers need those of pluginlib, each of which Debian puts into a folder of its own.
foreach(package pluginlib class_loader rcpputils rcutils ament_index_cpp)
  find_path(ROSBAG_${package}_INCLUDE_DIR ${package} PATHS ${ROSBAG_INCLUDE_DIR}/${package} NO_DEFAULT_PATH REQUIRED)
  list(APPEND ROSBAG_INCLUDE_DIRS ${ROSBAG_${package}_INCLUDE_DIR})
endforeach()
foreach(library rosbag_storage roscpp_serialization rostime cpp_common console_bridge)
  find_library(ROSBAG_${library}_LIBRARY ${library} REQUIRED)
endforeach()
if(NOT TARGET ROS::rosbag_storage)
  add_library(ROS::rosbag_storage UNKNOWN IMPORTED)
  set_target_properties(ROS::rosbag_storage PROPERTIES
    IMPORTED_LOCATION ${ROSBAG_rosbag_storage_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES "${ROSBAG_INCLUDE_DIRS}"
    INTERFACE_LINK_LIBRARIES
      "${ROSBAG_roscpp_serialization_LIBRARY};${ROSBAG_rostime_LIBRARY};${ROSBAG_cpp_common_LIBRARY};${ROSBAG_console_bridge_LIBRARY}")
endif()

# dynemo_use_ros_headers(TARGET FILE...): ROS 1's headers are valid up to C++17 only.
function(dynemo_use_ros_headers target)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-std=c++17;-Wno-deprecated-declarations")
endfunction()
