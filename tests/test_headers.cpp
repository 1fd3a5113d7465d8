// Nothing: the precompiled header that all test files share needs a target, and the target a file.
