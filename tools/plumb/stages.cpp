// plumb stages: every stage that exists.
#include <memory>
#include <nlohmann/json.hpp>

#include "gi/frame/frame.h"
#include "tools/plumb/cli.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

void add_stages(CLI::App& program, Action& action) {
    auto common = std::make_shared<Common>();
    CLI::App* command = program.add_subcommand("stages", "list every stage: inputs, outputs, parameters, twin, source");
    add_common(*command, *common);
    auto rules = std::make_shared<bool>(false);
    command->add_flag("--rules", *rules, "list the rules by which work is left out instead: which stages, and where");
    command->callback([common, rules, &action] {
        action = [common, rules] {
            common->run_options();
            if (*rules) {
                const std::vector<frame::Rule>& all = frame::rules();
                std::fputs((common->json ? json_text(rules_json(all)) : rules_text(all)).c_str(), stdout);
                return int(success);
            }
            const std::vector<StageInfo> stages = frame::all_stages();
            const std::string text = common->json ? json_text(stages_json(stages)) : stages_text(stages);
            std::fputs(text.c_str(), stdout);
            return int(success);
        };
    });
}

}  // namespace plumb::cli
