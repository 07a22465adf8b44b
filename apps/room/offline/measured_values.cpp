#include "apps/room/offline/measured_values.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "apps/output/csv_text.h"
#include "apps/room/offline/analysis_text.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/audio/sound_file.h"
#include "aula/engine/third_octaves.h"
#include "aula/exception.h"
#include "process/regular_file.h"

namespace aula {

namespace {

constexpr const char* kOctave = "octave";
constexpr const char* kThird = "third_octave";
constexpr const char* kMean = "mean";

std::string csv_value(const std::optional<double>& value) { return value ? json_value(value) : ""; }

/// The columns of frequencies.
std::vector<std::string> frequencies(bool third_octaves) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < (third_octaves ? kThirdOctaveCount : kBandCount); ++i)
        names.push_back(third_octaves ? third_octave_name(i) : band_name(i));
    return names;
}

/// Writes the rows of a response.
class ResponseRows {
 public:
    ResponseRows(const ResponseAnalysis& analysis, const std::vector<std::string>& columns)
        : columns_(columns), name_(csv_field(analysis.name)) {
        for (std::size_t p = 0; p < kAnalysedParameterCount; ++p) {
            std::map<std::string, std::optional<double>> values;
            for (std::size_t b = 0; b < kBandCount; ++b)
                values[band_name(b)] = analysis.parameters.octaves[p][b].value;
            add(kOctave, p, values, analysis.parameters.broadband[p].value);
        }
        text_ += name_ + ',' + kOctave + ",STI,," + std::string(columns_.size(), ',') +
                 csv_value(analysis.parameters.sti.value) + '\n';
        if (analysis.third_octaves.empty()) return;
        for (std::size_t p = 0; p < kAnalysedParameterCount; ++p) {
            std::map<std::string, std::optional<double>> values;
            for (std::size_t t = 0; t < kThirdOctaveCount; ++t)
                values[third_octave_name(t)] = analysed_value(analysis.third_octaves[t], p);
            add(kThird, p, values, {});
        }
    }

    const std::string& text() const { return text_; }

 private:
    void add(const char* bands, std::size_t p,
             const std::map<std::string, std::optional<double>>& values,
             const std::optional<double>& mean) {
        text_ += name_ + ',' + bands + ',' +
                 std::string(acoustic_parameter_name(acoustic_parameter(p))) + ',' +
                 std::string(acoustic_parameter_unit(acoustic_parameter(p)));
        for (const std::string& column : columns_) {
            const auto value = values.find(column);
            text_ += ',' + (value == values.end() ? "" : csv_value(value->second));
        }
        text_ += ',' + csv_value(mean) + '\n';
    }

    const std::vector<std::string>& columns_;
    std::string name_;
    std::string text_;
};

/// The cells of a line of CSV (RFC 4180), without spaces around them.
std::vector<std::string> cells_of(std::string_view line, char separator) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
            cells.back() += line[++i];
        } else if (c == '"') {
            quoted = !quoted;
        } else if (c == separator && !quoted) {
            cells.emplace_back();
        } else {
            cells.back() += c;
        }
    }
    for (std::string& cell : cells) {
        cell.erase(0, std::min(cell.find_first_not_of(" \t\r"), cell.size()));
        cell.erase(cell.find_last_not_of(" \t\r") + 1);
    }
    return cells;
}

/// Reads measured values from CSV.
class MeasuredReader {
 public:
    explicit MeasuredReader(const std::filesystem::path& file) : file_(file.string()) {
        // A row of 8 octaves has about 100 bytes, a response 8 rows: thousands of responses.
        constexpr std::uint64_t kMaxBytes = 16 << 20;
        std::istringstream in(read_regular_file(file, kMaxBytes, "a table of measured values"));
        std::string line;
        while (std::getline(in, line)) {
            ++line_;
            if (line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
            if (columns_.empty() && line.find(',') == std::string::npos &&
                line.find(';') != std::string::npos)
                separator_ = ';';
            const std::vector<std::string> cells = cells_of(line, separator_);
            const bool is_empty = std::all_of(cells.begin(), cells.end(),
                                              [](const std::string& c) { return c.empty(); });
            if (is_empty) continue;
            columns_.empty() ? read_header(cells) : read_row(cells);
        }
        if (columns_.empty())
            throw InputError(file_, "", "is empty" + std::string(kExpectedHeader));
        if (responses_.empty()) fail("has no values; expected a row for each parameter");
    }

    std::vector<MeasuredResponse> responses() { return std::move(responses_); }

 private:
    static constexpr const char* kExpectedHeader =
        "; expected a first line such as parameter,125,250,500,1000,2000,4000";

    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(file_, "line " + std::to_string(line_), what);
    }

    void read_header(const std::vector<std::string>& cells) {
        columns_ = cells;
        const auto count = [&](const std::string& name) {
            return std::count(cells.begin(), cells.end(), name);
        };
        if (count("parameter") != 1)
            fail("has no column \"parameter\"" + std::string(kExpectedHeader));
        bool has_band = count(kMean) > 0;
        for (std::size_t b = 0; b < kBandCount; ++b) has_band |= count(band_name(b)) > 0;
        if (!has_band) fail("has no column of an octave" + std::string(kExpectedHeader));
        for (const std::string& name : cells)
            if (!name.empty() && count(name) > 1)
                fail("has two columns \"" + name + "\"; expected different ones");
    }

    void read_row(const std::vector<std::string>& cells) {
        if (cells.size() > columns_.size())
            fail("has " + std::to_string(cells.size()) + " cells; expected at most " +
                 std::to_string(columns_.size()));
        std::string name;
        std::string symbol;
        std::map<std::string, std::string> values;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            if (columns_[i] == "bands" && cells[i] != kOctave && !cells[i].empty()) return;
            if (columns_[i] == "response") name = cells[i];
            if (columns_[i] == "parameter") symbol = cells[i];
            values[columns_[i]] = cells[i];
        }
        if (!rows_.insert({name, symbol}).second)
            fail("has " + symbol + " again" + (name.empty() ? "" : " of \"" + name + "\"") +
                 "; expected one row for each parameter of a response");
        PairParameters& parameters = response(name).parameters;
        if (symbol == "STI") {
            if (std::count(columns_.begin(), columns_.end(), kMean) == 0)
                fail("has STI; expected it in a column \"mean\"");
            parameters.sti.value = number("STI", values[kMean]);
            return;
        }
        const std::size_t p = index_of(symbol);
        for (std::size_t b = 0; b < kBandCount; ++b)
            parameters.octaves[p][b].value = number(symbol, values[band_name(b)]);
        parameters.broadband[p].value = number(symbol, values[kMean]);
        // As in a report, the mean of 500 and 1000 Hz.
        const auto& octaves = parameters.octaves[p];
        if (!parameters.broadband[p].value && octaves[3].value && octaves[4].value)
            parameters.broadband[p].value = (*octaves[3].value + *octaves[4].value) / 2;
    }

    MeasuredResponse& response(const std::string& name) {
        for (MeasuredResponse& known : responses_)
            if (known.name == name) return known;
        return responses_.emplace_back(MeasuredResponse{name, {}});
    }

    std::size_t index_of(const std::string& symbol) const {
        std::string names;
        for (std::size_t p = 0; p < kWithStrength; ++p) {
            if (symbol == acoustic_parameter_name(acoustic_parameter(p))) return p;
            names += std::string(acoustic_parameter_name(acoustic_parameter(p))) + ", ";
        }
        fail("has the parameter \"" + symbol + "\"; expected one of " + names + "STI");
    }

    std::optional<double> number(const std::string& symbol, std::string text) const {
        if (text.empty() || text == "-") return std::nullopt;
        if (separator_ == ';') std::replace(text.begin(), text.end(), ',', '.');
        double value = 0;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool is_share = symbol == "D50" || symbol == "STI";
        const bool is_time = symbol[0] == 'T' || symbol == "EDT";
        if (read.ec != std::errc() || read.ptr != text.data() + text.size() ||
            !(std::abs(value) <= kLargest))
            fail(symbol + " is \"" + text + "\"; expected a number, or nothing");
        if (is_share && !(value >= 0 && value <= 1))
            fail(symbol + " is " + text + "; expected 0 to 1");
        if (is_time && !(value > 0)) fail(symbol + " is " + text + "; expected seconds above 0");
        return value;
    }

    static constexpr double kLargest = 1000;  // s or dB
    static constexpr std::size_t kWithStrength = kAnalysedParameterCount + 1;

    std::string file_;
    std::size_t line_ = 0;
    char separator_ = ',';  ///< ';' where the comma is the decimal sign
    std::vector<std::string> columns_;
    std::set<std::pair<std::string, std::string>> rows_;  ///< names of response and parameter
    std::vector<MeasuredResponse> responses_;
};

}  // namespace

std::string measured_csv(std::span<const ResponseAnalysis> analyses) {
    const bool third_octaves = !analyses.empty() && !analyses[0].third_octaves.empty();
    const std::vector<std::string> columns = frequencies(third_octaves);
    std::string csv = "response,bands,parameter,unit";
    for (const std::string& column : columns) csv += ',' + column;
    csv += std::string(",") + kMean + '\n';
    for (const ResponseAnalysis& analysis : analyses) csv += ResponseRows(analysis, columns).text();
    return csv;
}

std::vector<MeasuredResponse> read_measured(const std::filesystem::path& file,
                                            std::vector<std::string>& warnings) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (extension == ".csv") return MeasuredReader(file).responses();
    std::vector<MeasuredResponse> responses;
    try {
        sound_info(file);
    } catch (const InputError& error) {
        throw InputError(std::string(error.what()) + ", or a table of measured values, NAME.csv");
    }
    for (std::optional<ResponseAnalysis>& analysis : analyse_file(file, {})) {
        if (!analysis) continue;
        warnings.insert(warnings.end(), analysis->warnings.begin(), analysis->warnings.end());
        analysis->parameters.sti = {};
        responses.push_back({analysis->name, analysis->parameters, analysis->transfers});
    }
    return responses;
}

}  // namespace aula
