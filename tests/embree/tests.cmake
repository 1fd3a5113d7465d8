# The rasterizer against ray casting by somebody else.
find_package(embree 3 REQUIRED)
plumb_add_tests(embree plumb::io plumb::raster embree)
