# OpenImageIO makes samples of formats that io/ only reads; tinyobjloader is the second opinion on OBJ.
target_link_libraries(test_io PRIVATE PkgConfig::OpenImageIO tinyobjloader::tinyobjloader fmt::fmt)
