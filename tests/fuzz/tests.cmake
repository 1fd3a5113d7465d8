# The readers as fuzzers run them. test_io reads the corpus with them in every build; with PLUMB_FUZZ, plumb_fuzz changes it.
set(fuzz_targets ${CMAKE_CURRENT_LIST_DIR}/fuzz_obj.cpp ${CMAKE_CURRENT_LIST_DIR}/fuzz_gltf.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fuzz_picture.cpp ${CMAKE_CURRENT_LIST_DIR}/fuzz_file.cpp ${CMAKE_CURRENT_LIST_DIR}/scratch.cpp ${CMAKE_CURRENT_LIST_DIR}/whole.cpp
  ${CMAKE_CURRENT_LIST_DIR}/watch.cpp)
target_sources(test_io PRIVATE ${fuzz_targets})

if(PLUMB_FUZZ)
  find_package(ZLIB REQUIRED)
  add_executable(plumb_fuzz ${fuzz_targets} fuzz/fuzzer.cpp fuzz/mutate.cpp fuzz/mutate_json.cpp fuzz/png_parts.cpp)
  target_link_libraries(plumb_fuzz PRIVATE plumb::io plumb_warnings nlohmann_json::nlohmann_json ZLIB::ZLIB
    PkgConfig::OpenImageIO)
  target_link_options(plumb_fuzz PRIVATE -fsanitize=fuzzer)
  add_executable(plumb_fuzz_seeds fuzz/seeds.cpp fuzz/png_parts.cpp)
  target_link_libraries(plumb_fuzz_seeds PRIVATE plumb::io plumb_warnings nlohmann_json::nlohmann_json ZLIB::ZLIB
    PkgConfig::OpenImageIO)
endif()
