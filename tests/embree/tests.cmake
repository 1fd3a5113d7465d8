# The rasterizer against ray casting by somebody else; and our own rays.
plumb_add_tests(embree plumb::io plumb::gi embree)
