# Links of docs/api.md, written for a forge, in the reference of the headers: pages of docs/ are not
# part of it; source files are, by their names.
s|\[\([^]]*\)\]([a-z_]*\.md\(#[a-z-]*\)\{0,1\})|\1|g
s|](\.\./[^)]*/\([^)/]*\))|](@ref \1)|g
