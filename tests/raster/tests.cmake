# The scenes of data/, for the passes bound to their data.
target_link_libraries(test_raster PRIVATE plumb::io)
