#include "tools/shared/command.h"

#include <fmt/format.h>

namespace plumb::cli {

RunOptions Common::run_options() const {
    RunOptions options;
    options.isa = parse_isa(isa);
    options.threads = threads;
    return options;
}

CLI::Validator number_within(double min, double max) {
    return {[=](std::string& text) {
                double number = 0;
                const bool inside = CLI::detail::lexical_cast(text, number) && number >= min && number <= max;
                return inside ? std::string() : fmt::format("{}: expected {} to {}", text, min, max);
            },
            ""};
}

CLI::Validator some_word() {
    return {[](std::string& text) { return text.empty() ? std::string("expected a value") : std::string(); }, ""};
}

void add_common(CLI::App& command, Common& common) {
    command.add_flag("--json", common.json, "print one JSON value to standard output and nothing else");
    command.add_option("--threads", common.threads, "threads that compute, 1 to 1024; all processors otherwise")
        ->check(CLI::Range(1, 1024).description(""))
        ->type_name("N");
    command.add_option("--isa", common.isa,
                       "auto, scalar, sse, avx2 or avx512: changes no bit but the last ones of native rays")
        ->type_name("ISA");
}

}  // namespace plumb::cli
