# PCL's own package file looks for VTK, Qt and MPI too: target PCL::registration, with what it stands on.
find_path(PCL_INCLUDE_DIR pcl/registration/gicp.h PATH_SUFFIXES pcl-1.13 pcl-1.14 pcl-1.15 pcl REQUIRED)
find_library(PCL_REGISTRATION_LIBRARY pcl_registration REQUIRED)
set(pcl_parts "")
foreach(part filters sample_consensus search kdtree octree features common)
  find_library(PCL_${part}_LIBRARY pcl_${part} REQUIRED)
  list(APPEND pcl_parts ${PCL_${part}_LIBRARY})
endforeach()
if(NOT TARGET PCL::registration)
  add_library(PCL::registration UNKNOWN IMPORTED)
  set_target_properties(PCL::registration PROPERTIES
    IMPORTED_LOCATION ${PCL_REGISTRATION_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${PCL_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES "${pcl_parts};Eigen3::Eigen;Boost::headers")
endif()
