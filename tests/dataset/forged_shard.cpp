#include "tests/dataset/forged_shard.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <utility>
#include <vector>

#include "apps/dataset/base/sha256.h"
#include "apps/dataset/base/tar.h"

namespace aula::test {

void forge_shard(const std::filesystem::path& shard,
                 const std::function<void(std::size_t, std::string&, std::string&)>& change) {
    std::vector<std::pair<std::string, std::string>> members;
    {
        TarReader reader(shard);
        while (const auto member = reader.next())
            members.emplace_back(member->name, reader.read(*member));
    }
    std::ofstream out(shard, std::ios::binary);
    const auto put = [&](const std::string& name, const std::string& content) {
        out << tar_header(name, content.size()) << content << tar_padding(content.size());
    };
    std::size_t item = 0;
    for (std::size_t m = 0; m < members.size(); ++item) {
        const std::string name = members[m].first;
        std::string json = members[m++].second;
        std::string wav;
        const bool has_wav = m < members.size() && members[m].first.ends_with(".wav");
        if (has_wav) wav = members[m++].second;
        json.resize(json.rfind(", \"item_sha256\""));
        change(item, json, wav);
        put(name, json + ", \"item_sha256\": \"" + sha256(json + wav) + "\"}\n");
        if (!wav.empty()) put(name.substr(0, name.find('.')) + ".wav", wav);
    }
    out << tar_end();
    REQUIRE(out.flush());
}

void replace_part(std::string& text, const std::string& part, const std::string& instead) {
    INFO(part);
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    text.replace(at, part.size(), instead);
}

}  // namespace aula::test
