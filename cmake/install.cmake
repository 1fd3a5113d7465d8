# cmake --install: libraries, headers, program, licence and a package, so that find_package(plumbline) gives plumb::core,
# plumb::raster, plumb::gi and plumb::io. The flags of plumb_flags travel with them: kernels that a consumer instantiates
# keep the promise of equal bits.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/plumbline)

set_target_properties(plumb_flags PROPERTIES EXPORT_NAME flags)
foreach(name core raster gi io)
  set_target_properties(plumb_${name} PROPERTIES EXPORT_NAME ${name})
endforeach()
install(TARGETS plumb_flags plumb_core plumb_raster plumb_gi plumb_io EXPORT plumbline)
install(EXPORT plumbline NAMESPACE plumb:: DESTINATION ${package_dir})
if(TARGET plumb)
  install(TARGETS plumb)
endif()

install(DIRECTORY core raster gi io DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/plumbline FILES_MATCHING PATTERN "*.h"
  # They see Embree.
  PATTERN "gi/reference/embree_scene.h" EXCLUDE PATTERN "gi/reference/packet_query.h" EXCLUDE
  PATTERN "gi/reference/ray_device.h" EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(cmake/plumblineConfig.cmake.in ${CMAKE_BINARY_DIR}/package/plumblineConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS CMAKE_INSTALL_BINDIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/plumblineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/plumblineConfig.cmake ${CMAKE_BINARY_DIR}/package/plumblineConfigVersion.cmake
  cmake/PlumblineValidate.cmake
  DESTINATION ${package_dir})
