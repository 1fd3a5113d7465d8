# Renderers whose shaders are not our twins, judged by `plumb validate` as anybody's are. Skipped, and said so, where the
# library, the driver or OpenGL are not there.
if(TARGET plumb_vulkan AND TARGET plumb)
  plumb_add_tests(foreign plumb_vulkan plumb::io nlohmann_json::nlohmann_json)
  target_sources(test_foreign PRIVATE ${PROJECT_SOURCE_DIR}/tools/mutants/mutant.cpp
    ${PROJECT_SOURCE_DIR}/tests/program/program.cpp)
  file(GLOB foreign_sources CONFIGURE_DEPENDS foreign/*.cpp)
  list(FILTER foreign_sources EXCLUDE REGEX "/test_[^/]*$")
  target_sources(test_foreign PRIVATE ${foreign_sources})
  target_compile_definitions(test_foreign PRIVATE PLUMB_PROGRAM="$<TARGET_FILE:plumb>" PLUMB_GLSLANG="${GLSLANG}")
  add_dependencies(test_foreign plumb)
  # Their OpenGL is Mesa's without a window.
  find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
  if(TARGET OpenGL::EGL AND TARGET OpenGL::OpenGL)
    target_link_libraries(test_foreign PRIVATE OpenGL::EGL OpenGL::OpenGL)
    target_compile_definitions(test_foreign PRIVATE PLUMB_WITH_OPENGL)
  endif()
else()
  add_test(NAME foreign COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: built without Vulkan (libvulkan-dev)")
  set(tests_foreign foreign)
endif()
set_tests_properties(${tests_foreign} PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 600)
