#include "core/fp_environment.h"
#include "tools/plumb/cli.h"
#include "tools/shared/outputs.h"

int main(int argc, char** argv) {
    plumb::FpEnvironment environment;
    plumb::cli::watch_signals();
    return plumb::cli::run_program(argc, argv);
}
