# Every package comes from Debian 12 (tools/install-deps).
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(glm REQUIRED)
find_package(fmt REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PNG REQUIRED)
find_package(embree 3 REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)

# OpenImageIO's CMake package names a path of OpenCV that Debian 12 does not have, so its pkg-config file is used.
find_package(PkgConfig REQUIRED)
pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET OpenImageIO)

# Optional: for tools/vulkan, which runs scenes and twins on a Vulkan device (libvulkan-dev; mesa-vulkan-drivers is a
# software device).
find_package(Vulkan QUIET)
if(NOT TARGET Vulkan::Vulkan)
  message(STATUS "Vulkan not found (libvulkan-dev): built without comparisons against Vulkan devices")
endif()
