#include "apps/dataset/shards/status.h"

#include <filesystem>
#include <system_error>

#include "apps/dataset/shards/shard_reader.h"
#include "aula/exception.h"

namespace aula {

DatasetStatus dataset_status(const Plan& plan, bool verifies,
                             const std::function<bool()>& continues) {
    check_scenes(plan);
    DatasetStatus status;
    for (std::size_t shard = 0; shard < plan.shards.size() && continues(); ++shard) {
        DatasetStatus found;
        try {
            ShardReader reader(plan, shard);
            while (continues() && reader.next()) {
                ShardItem item;
                if (verifies || !reader.has_response()) item = reader.read();
                if (reader.has_response())
                    ++found.responses;
                else
                    found.failures.push_back("item " + std::to_string(reader.item()) + ": " +
                                             item.error);
            }
        } catch (const InputError& error) {
            status.missing.push_back(shard);
            std::error_code ignored;
            if (std::filesystem::exists(
                    std::filesystem::symlink_status(plan.shard_file(shard), ignored)))
                status.damaged.emplace_back(error.what());
            continue;
        }
        status.responses += found.responses;
        status.failures.insert(status.failures.end(), found.failures.begin(), found.failures.end());
    }
    return status;
}

std::string array_text(const std::vector<std::size_t>& numbers) {
    std::string text;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
        if (!text.empty()) text += ',';
        text += std::to_string(numbers[i]);
        if (end > i + 1) text += '-' + std::to_string(numbers[end - 1]);
        i = end;
    }
    return text;
}

}  // namespace aula
