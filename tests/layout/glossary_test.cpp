#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <string_view>

namespace {

namespace fs = std::filesystem;

/// Helpers of one file or of the standard library's interfaces, whose names need no explanation.
const std::set<std::string> kExceptions{
    "AlignedAllocator", "Floats",    "Halves",    "HugePageArena", "MixHash", "RandomStream",
    "ScrambledSobol",   "Semaphore", "Stopwatch", "Transform",     "Turn",    "Twiddle",
    "VectorOf"};

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// "segment cache" of "SegmentCache", "json reader" of "JsonReader".
std::string words_of(const std::string& type) {
    return lower(std::regex_replace(type, std::regex("([a-z])([A-Z])"), "$1 $2"));
}

/// The entries of the glossary in lower case: what commas and parentheses separate in the left
/// columns of its tables.
std::set<std::string> glossary_entries() {
    std::ifstream in(fs::path(AULA_SOURCE_DIR) / "docs/glossary.md");
    std::set<std::string> entries;
    const std::regex entry("[^,()`|]*[^,()`| ]");
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("| ")) continue;
        const std::string words = lower(line.substr(0, line.find(" | ")));
        for (std::sregex_iterator it(words.begin(), words.end(), entry), end; it != end; ++it) {
            entries.insert(it->str().substr(it->str().find_first_not_of(' ')));
        }
    }
    return entries;
}

}  // namespace

TEST_CASE(
    "every type of the headers of engine, audio, dataset, documents, output, room and window is in "
    "the "
    "glossary") {
    const std::set<std::string> entries = glossary_entries();
    const std::regex declaration("^(?:class|struct) ([A-Z]\\w+)(?: final)?(?: :.*)? \\{");
    std::set<std::string> types;
    for (const std::string_view root : {"engine", "audio", "apps/dataset", "apps/documents",
                                        "apps/output", "apps/room", "apps/window"}) {
        for (const auto& entry :
             fs::recursive_directory_iterator(fs::path(AULA_SOURCE_DIR) / root)) {
            if (entry.path().extension() != ".h") continue;
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);) {
                std::smatch match;
                if (!std::regex_search(line, match, declaration)) continue;
                types.insert(match[1]);
                INFO(entry.path() << ": add " << match[1] << " to docs/glossary.md as \""
                                  << words_of(match[1]) << "\"");
                CHECK((kExceptions.contains(match[1]) || entries.contains(words_of(match[1]))));
            }
        }
    }
    CHECK(types.size() > 150);
    for (const std::string& exception : kExceptions) {
        INFO(exception << " is gone, or explained: drop it from the exceptions");
        CHECK((types.contains(exception) && !entries.contains(words_of(exception))));
    }
}

TEST_CASE("the glossary's entries are whole words") {
    const std::set<std::string> entries = glossary_entries();
    CHECK(entries.contains(words_of("SegmentCache")));
    CHECK(entries.contains(words_of("JsonMember")));
    CHECK_FALSE(entries.contains(words_of("Transform")));  // "block transform" is an entry
    CHECK_FALSE(entries.contains(words_of("SegmentCach")));
}
