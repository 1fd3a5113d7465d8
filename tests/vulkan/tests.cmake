# The layer over Vulkan, on the software driver. Skipped, and said so, where the library, the driver or shaders are not
# there.
if(TARGET plumb_vulkan)
  file(GLOB vulkan_shaders CONFIGURE_DEPENDS vulkan/*.vert vulkan/*.frag)
  plumb_compile_twins(vulkan_test_shaders ${vulkan_shaders})
endif()
if(TARGET vulkan_test_shaders)
  plumb_add_tests(vulkan plumb_vulkan plumb::raster)
  target_compile_definitions(test_vulkan PRIVATE PLUMB_SPIRV_DIR="${CMAKE_BINARY_DIR}/twins")
  add_dependencies(test_vulkan vulkan_test_shaders)
else()
  add_test(NAME vulkan COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: built without Vulkan (libvulkan-dev) or shaders")
endif()
set_tests_properties(vulkan PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 60)
