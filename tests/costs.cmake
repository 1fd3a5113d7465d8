# Entries that take long start first; among the others ctest goes by what it measured last.
