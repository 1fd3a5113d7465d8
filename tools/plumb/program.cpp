#include <fmt/format.h>

#include <cstdio>

#include "core/error.h"
#include "core/nearest_known.h"
#include "tools/plumb/cli.h"
#include "tools/shared/outputs.h"

namespace plumb::cli {

namespace {

constexpr const char* version = PLUMB_VERSION;

// The name of an argument that looks like an option: "--threads=3" is "--threads".
std::string option_name(const std::string& argument) { return argument.substr(0, argument.find('=')); }

bool is_option(const std::string& argument) { return argument.size() > 1 && argument[0] == '-'; }

std::vector<std::string> option_names(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
        for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    }
    return names;
}

// The parser itself does not know the nearest command.
void check_command(const CLI::App& program, const std::string& name) {
    std::vector<std::string> known;
    for (const CLI::App* command : program.get_subcommands({})) known.push_back(command->get_name());
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    const std::string what = program.get_parent() ? program.get_name() : "command";
    throw InputError(fmt::format("unknown {} '{}'{}", what, name, nearest_known(name, known)));
}

std::string extras_message(const CLI::App& program) {
    const CLI::App* command = &program;
    // Experiments are commands of a command.
    while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
    const std::vector<std::string> extras = command->remaining();
    if (extras.empty()) return "unexpected arguments";
    const std::string name = option_name(extras.front());
    const std::string where = command == &program ? "" : command->get_name() + ": ";
    if (!is_option(name)) return fmt::format("{}unexpected argument '{}'", where, extras.front());
    return fmt::format("{}unknown option '{}'{}", where, name, nearest_known(name, option_names(*command)));
}

int fail(int code, std::string message) {
    wait_if_interrupted();
    // One line, whatever a library put into its message.
    for (char& c : message)
        if (c == '\n' || c == '\r') c = ' ';
    message.erase(message.find_last_not_of(' ') + 1);
    std::fflush(stdout);
    std::fprintf(stderr, "plumb: %s\n", message.c_str());
    return code;
}

int parse_and_run(CLI::App& program, Action& action, int argc, char** argv) {
    if (argc < 2) throw InputError("expected a command; plumb --help lists them");
    if (!is_option(argv[1])) check_command(program, argv[1]);
    if (argc > 2 && !is_option(argv[1]) && !is_option(argv[2])) {
        const CLI::App* command = program.get_subcommand(argv[1]);
        if (!command->get_subcommands({}).empty()) check_command(*command, argv[2]);
    }
    try {
        program.parse(argc, argv);
    } catch (const CLI::ExtrasError&) {
        throw InputError(extras_message(program));
    } catch (const CLI::Success& asked_for) {  // --help, --version
        return program.exit(asked_for);
    } catch (const CLI::ParseError& error) {
        throw InputError(error.what());
    }
    if (!action) throw InputError("expected a command; plumb --help lists them");
    return action();
}

}  // namespace

int run_program(int argc, char** argv) {
    CLI::App program{"The CPU ground truth for GPU global illumination", "plumb"};
    program.set_version_flag("--version", fmt::format("plumb {}", version));
    program.require_subcommand(0, 1);
    Action action;
    add_render(program, action);
    add_plan(program, action);
    add_graph(program, action);
    add_bake(program, action);
    add_lightmap(program, action);
    add_compare(program, action);
    add_explain(program, action);
    add_validate(program, action);
    add_export(program, action);
    add_sweep(program, action);
    add_stability(program, action);
    add_stages(program, action);
    add_devices(program, action);
    add_probe_device(program, action);
    add_experiment(program, action);
    add_make_scene(program, action);
    add_pov(program, action);
    add_cameras(program, action);
    add_batch(program, action);
    add_formfactor(program, action);
    // After the commands, which would take it for theirs.
    program.footer(
        "Examples:\n"
        "  plumb make-scene cornell -o out/cornell\n"
        "  plumb plan out/cornell/cornell.toml\n"
        "  plumb render out/cornell/cornell.toml -o out/cornell --set rsm.samples=150\n"
        "  plumb explain out/cornell/cornell.toml --stage rsm.paths --pixel 512,700\n"
        "  plumb compare out/cornell/cornell.exr mine.exr --max-error 1e-4 -o difference.png\n"
        "plumb COMMAND --help tells more. Exit codes: 0 success, 1 disagreement, 2 bad usage or input, 3 internal "
        "error.");
    try {
        const int code = parse_and_run(program, action, argc, argv);
        if (std::fflush(stdout) != 0 || std::ferror(stdout)) return fail(bad_input, "cannot write to standard output");
        return code;
    } catch (const InputError& error) {
        return fail(bad_input, error.what());
    } catch (const std::bad_alloc&) {
        return fail(internal_error, "internal error: out of memory");
    } catch (const std::exception& error) {
        return fail(internal_error, std::string("internal error: ") + error.what());
    }
}

}  // namespace plumb::cli
