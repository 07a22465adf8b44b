#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace aula::bench {

/// A figure of a row. No value is null in JSON and "-" in a table.
using Value =
    std::variant<std::monostate, double, std::int64_t, std::string, std::array<double, 3>>;

/// One result: its figures in order, under their names in JSON.
struct Row {
    std::vector<std::pair<std::string, Value>> figures;

    const Value& at(const std::string& name) const;
};

/// A column of the printed table.
struct Column {
    std::string figure;  ///< name in Row
    std::string heading;
    int decimals = 0;
};

/// Columns of the engine's figures by name; each name must be known.
std::vector<Column> columns_of(std::initializer_list<const char*> figures);

/// Rows aligned under their headings: text left-aligned, numbers right-aligned.
std::string format_table(const std::vector<Column>& columns, const std::vector<Row>& rows);

/// The same as a Markdown table.
std::string format_markdown(const std::vector<Column>& columns, const std::vector<Row>& rows);

/// {"machine": .., "rows": [..]}
std::string to_json(const std::vector<Row>& rows);

}  // namespace aula::bench
