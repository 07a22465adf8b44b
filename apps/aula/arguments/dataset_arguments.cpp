#include "apps/aula/arguments/dataset_arguments.h"

#include <array>
#include <functional>
#include <map>
#include <utility>

#include "apps/aula/arguments/argument_values.h"
#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

/// "HH:MM:SS", optionally with days as "D-HH:MM:SS".
std::string read_time(const std::string& option, const std::string& text) {
    const std::size_t dash = text.find('-');
    const std::string clock = dash == std::string::npos ? text : text.substr(dash + 1);
    bool usable = clock.size() == 8 && dash != 0;
    for (std::size_t i = 0; i < text.size() && usable; ++i) {
        const bool colon = text.size() - i == 3 || text.size() - i == 6;
        usable = i == dash || (colon ? text[i] == ':' : text[i] >= '0' && text[i] <= '9');
    }
    if (!usable) refuse_value(option, text, "a time as 04:00:00 or 1-00:00:00");
    return text;
}

/// The words of one command: its operand and its options.
class Words {
 public:
    using Take = std::function<void(const std::string& option, const std::string& value)>;

    void option(const std::string& name, Take take) { options_[name] = std::move(take); }
    void flag(const std::string& name, bool& set) { flags_[name] = &set; }

    /// Parses all words from the second on. Returns the operand; `what` describes it.
    std::string parse(const std::vector<std::string>& words, const std::string& what) {
        const std::string place = "dataset " + words[0];
        std::vector<std::string> operands, seen;
        for (std::size_t i = 1; i < words.size(); ++i) {
            if (!words[i].starts_with("--")) {
                operands.push_back(words[i]);
                continue;
            }
            const std::size_t equals = words[i].find('=');
            const std::string name = words[i].substr(0, equals);
            for (const std::string& other : seen)
                if (other == name)
                    throw InputError(name + ": is given more than once; expected it once");
            seen.push_back(name);
            const auto flag = flags_.find(name);
            if (flag != flags_.end() && equals == std::string::npos) {
                *flag->second = true;
                continue;
            }
            const auto option = options_.find(name);
            if (option == options_.end())
                throw InputError(place, "",
                                 "\"" + words[i] + "\" is not known; expected " + known());
            if (equals == std::string::npos && i + 1 == words.size())
                throw InputError(name + ": has no value; expected one");
            option->second(name,
                           equals == std::string::npos ? words[++i] : words[i].substr(equals + 1));
        }
        if (operands.empty() || operands[0].empty())
            throw InputError(place, "", "no " + what + " given; expected one");
        if (operands.size() > 1)
            throw InputError(
                place, "",
                "\"" + operands[1] + "\" is one argument too many; expected one " + what);
        for (const std::string& name : required_)
            if (std::find(seen.begin(), seen.end(), name) == seen.end())
                throw InputError(place, "", name + " is missing; expected it");
        return operands[0];
    }

    void require(const std::string& name) { required_.push_back(name); }

 private:
    std::string known() const {
        std::string names;
        for (const auto& [name, take] : options_) names += (names.empty() ? "" : ", ") + name;
        for (const auto& [name, set] : flags_) names += (names.empty() ? "" : ", ") + name;
        return names;
    }

    std::map<std::string, Take> options_;
    std::map<std::string, bool*> flags_;
    std::vector<std::string> required_;
};

}  // namespace

DatasetArguments read_dataset_arguments(const std::vector<std::string>& words) {
    using Command = DatasetArguments::Command;
    constexpr std::array<std::pair<const char*, Command>, 5> kCommands{{{"plan", Command::plan},
                                                                        {"run", Command::run},
                                                                        {"status", Command::status},
                                                                        {"slurm", Command::slurm},
                                                                        {"merge", Command::merge}}};
    constexpr const char* kExpected = "expected plan, run, status, slurm or merge";
    constexpr std::size_t kMostShards = 10'000'000;
    DatasetArguments arguments;
    if (words.empty()) throw InputError(std::string("dataset: no command given; ") + kExpected);
    const auto command = std::find_if(kCommands.begin(), kCommands.end(),
                                      [&](const auto& known) { return words[0] == known.first; });
    if (command == kCommands.end())
        throw InputError("dataset: \"" + words[0] + "\" is not known; " + kExpected);
    arguments.command = command->second;

    Words parser;
    parser.flag("--quiet", arguments.quiet);
    const auto count = [&](const std::string& name, auto& number, auto min, auto max) {
        parser.option(
            name, [&number, min, max](const std::string& option, const std::string& text) {
                using T = std::remove_reference_t<decltype(number)>;
                number = read_whole<T>(option, text, static_cast<T>(min), static_cast<T>(max));
            });
    };
    switch (arguments.command) {
        case Command::plan:
            parser.option("--out", [&](const std::string& option, const std::string& text) {
                if (text.empty()) refuse_value(option, text, "the name of a folder");
                arguments.folder = utf8_path(text);
            });
            count("--shards", arguments.shards, 1, kMostShards);
            parser.require("--out");
            parser.require("--shards");
            arguments.manifest = utf8_path(parser.parse(words, "manifest"));
            return arguments;
        case Command::run:
            count("--shard", arguments.shard, 0, kMostShards - 1);
            count("--threads", arguments.threads, 1, 1024);
            parser.require("--shard");
            break;
        case Command::status:
            parser.flag("--missing", arguments.missing);
            parser.flag("--verify", arguments.verify);
            break;
        case Command::slurm:
            count("--cpus", arguments.slurm.cpus, 1, 1024);
            count("--limit", arguments.slurm.limit, 1, 1'000'000);
            parser.option("--time", [&](const std::string& option, const std::string& text) {
                arguments.slurm.time = read_time(option, text);
            });
            break;
        case Command::merge:
            parser.option("--to", [&](const std::string& option, const std::string& text) {
                const auto format = merge_format(text);
                if (!format) refuse_value(option, text, "hdf5, sofa or wav");
                arguments.format = *format;
            });
            parser.require("--to");
            break;
    }
    arguments.folder = utf8_path(parser.parse(words, "folder"));
    return arguments;
}

}  // namespace aula
