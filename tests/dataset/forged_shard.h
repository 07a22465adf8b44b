#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace aula::test {

/// Rewrites a shard as somebody could who knows its format: `change` may change the description of
/// an item, without its hash, and its response; then headers and hashes are those of the content.
void forge_shard(
    const std::filesystem::path& shard,
    const std::function<void(std::size_t item, std::string& json, std::string& wav)>& change);

/// Replaces a part of a text, which it must contain.
void replace_part(std::string& text, const std::string& part, const std::string& instead);

}  // namespace aula::test
