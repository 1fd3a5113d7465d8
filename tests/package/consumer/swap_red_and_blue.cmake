# The manifest of a pass whose output has red and blue the other way round.
file(READ ${FOLDER}/manifest.toml text)
string(REPLACE "out/radiance.bin\"\n" "out/radiance.bin\"\nchannels = \"zyx\"\n" text "${text}")
file(WRITE ${FOLDER}/wrong.toml "${text}")
