# cmake -D INPUT=... -D OUTPUT=... -D SYMBOL=... -P EmbedText.cmake: writes a C++ source that
# contains a text file as the string aula::SYMBOL.
file(READ "${INPUT}" text)
file(WRITE "${OUTPUT}" "namespace aula {
extern const char* const ${SYMBOL};
const char* const ${SYMBOL} = R\"embedded(${text})embedded\";
}  // namespace aula
")
