# OpenImageIO makes samples of formats that io/ only reads; tinyobjloader and tinygltf are second opinions.
find_package(TinyGLTF REQUIRED)
target_link_libraries(test_io PRIVATE PkgConfig::OpenImageIO tinyobjloader::tinyobjloader TinyGLTF::TinyGLTF
  fmt::fmt)
