"""Counts what the house is measured by: `sh tests/figures.sh` says how to run it.

Every figure is defined by the function that counts it; the standard library is all that is needed.
Sources are read as text: comments, literals and `#[cfg(test)]` items are blanked first where a figure is about code.
"""

import collections
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def rust_files(*folders):
    for folder in folders:
        for path, folders_below, names in os.walk(os.path.join(ROOT, folder)):
            folders_below.sort()
            for name in sorted(names):
                if name.endswith(".rs"):
                    full = os.path.join(path, name)
                    yield os.path.relpath(full, ROOT).replace(os.sep, "/"), open(full, encoding="utf-8").read()


TOKEN = re.compile(
    r"""(?P<line>//[^\n]*)|(?P<block>/\*)|(?P<raw>b?r(?P<hashes>\#*)")|(?P<string>b?"(?:\\.|[^"\\])*")"""
    r"""|(?P<char>b?'(?:\\(?:u\{[^}]*\}|x..|.)|[^'\\])')""",
    re.S,
)


def blank(text):
    """The same text, as long, without its line breaks lost."""
    return re.sub(r"[^\n]", " ", text)


def without_comments_and_literals(text):
    out, at = [], 0
    while match := TOKEN.search(text, at):
        out.append(text[at : match.start()])
        end = match.end()
        if match.group("block"):
            depth = 1
            while depth and (edge := re.compile(r"/\*|\*/").search(text, end)):
                depth += 1 if edge.group() == "/*" else -1
                end = edge.end()
        elif match.group("raw"):
            close = text.find('"' + match.group("hashes"), end)
            end = len(text) if close < 0 else close + 1 + len(match.group("hashes"))
        out.append(blank(text[match.start() : end]))
        at = end
    return "".join(out) + text[at:]


def without_tests(code):
    """`code` (already blanked) without what `#[cfg(test)]` stands before."""
    for match in reversed(list(re.finditer(r"#\[cfg\(test\)\]", code))):
        brace, semicolon = code.find("{", match.end()), code.find(";", match.end())
        if semicolon >= 0 and (brace < 0 or semicolon < brace):
            end = semicolon + 1
        else:
            end, depth = brace, 0
            while end < len(code):
                depth += {"{": 1, "}": -1}.get(code[end], 0)
                end += 1
                if depth == 0:
                    break
        code = code[: match.start()] + blank(code[match.start() : end]) + code[end:]
    return code


class Source:
    def __init__(self, path, text):
        self.path, self.text = path, text
        self.code = without_comments_and_literals(text)
        if not path.endswith("/tests.rs"):
            self.code = without_tests(self.code)
        else:
            self.code = blank(self.code)

    @property
    def room(self):
        parts = self.path.split("/")
        return parts[1] if len(parts) > 2 else "(root)"

    @property
    def module(self):
        """`src/app/space/mod.rs` is `app::space`."""
        parts = self.path[len("src/") : -len(".rs")].split("/")
        if parts[-1] in ("mod", "lib", "main"):
            parts.pop()
        return tuple(parts)


SOURCES = [Source(path, text) for path, text in rust_files("src")]


def lines_by_room():
    table = collections.defaultdict(lambda: [0, 0])
    for source in SOURCES:
        table[source.room][0] += 1
        table[source.room][1] += source.text.count("\n")
    return table


# ---- the window ----


def braces_end(code, start):
    depth = 0
    for at in range(start, len(code)):
        depth += {"{": 1, "}": -1}.get(code[at], 0)
        if depth == 0:
            return at + 1
    return len(code)


def app_sources():
    return [source for source in SOURCES if source.path.startswith("src/app/")]


def editor_fields():
    """Public fields of the struct `Editor`."""
    for source in app_sources():
        if match := re.search(r"pub struct Editor\s*\{", source.code):
            body = source.code[match.end() : braces_end(source.code, match.end() - 1)]
            return len(re.findall(r"^\s*pub(?:\([^)]*\))? \w+:", body, re.M))
    return 0


def editor_methods():
    """Methods of `Editor`, and `impl` blocks that hold them."""
    methods = blocks = 0
    for source in app_sources():
        for match in re.finditer(r"^impl(?: eframe::App for| \w+ for)? (?:super::)*(?:editor::)?Editor\s*\{", source.code, re.M):
            blocks += 1
            body = source.code[match.end() : braces_end(source.code, match.end() - 1)]
            methods += len(re.findall(r"\bfn \w+", body))
    return methods, blocks


SIGNATURE = re.compile(r"\bfn (\w+)\s*(?:<[^{;]*?>)?\s*\(([^{;]*?)\)\s*(?:->[^{;]*)?(?:where[^{]*)?\{", re.S)


def drawing_with_editor():
    """Functions that take a `Ui` and `&mut Editor` (or are methods of `Editor` with `&mut self` and a `Ui`)."""
    count = 0
    for source in app_sources():
        inside = []
        for match in re.finditer(r"^impl(?: eframe::App for| \w+ for)? (?:super::)*(?:editor::)?Editor\s*\{", source.code, re.M):
            inside.append((match.end(), braces_end(source.code, match.end() - 1)))
        for match in SIGNATURE.finditer(source.code):
            parameters = match.group(2)
            draws = re.search(r"\bUi\b", parameters)
            own = any(start <= match.start() < end for start, end in inside) and "&mut self" in parameters
            if draws and (re.search(r"&(?:'\w+ )?mut (?:super::)*Editor\b", parameters) or own):
                count += 1
    return count


USE_OR_PATH = re.compile(r"\b(crate|super|self)((?:::super)*)::")


def used_modules(source, modules):
    """The modules (as files) below `modules` that a source names, by the longest path that is a file."""
    found = set()
    code = source.code
    for match in USE_OR_PATH.finditer(code):
        if code[max(0, match.start() - 2) : match.start()] == "::":
            continue
        base = {"crate": source.module[:1] if source.room != "(root)" else (), "super": source.module[:-1], "self": source.module}[match.group(1)]
        if match.group(1) != "crate":
            for _ in range(match.group(2).count("super")):
                base = base[:-1]
        read_tree(code, match.end(), base, found, modules)
    return found


def read_tree(code, at, base, found, modules):
    """Reads a path or a `{...}` of paths from `at`; returns the position behind it."""
    while True:
        at = skip_blanks(code, at)
        if at < len(code) and code[at] == "{":
            at += 1
            while True:
                at = skip_blanks(code, at)
                if at >= len(code) or code[at] == "}":
                    return at + 1
                if code[at] == ",":
                    at += 1
                    continue
                before = at
                at = read_tree(code, at, base, found, modules)
                if at == before:
                    return at + 1
        word = re.compile(r"\w+|\*").match(code, at)
        if not word:
            break
        at = word.end()
        if word.group() == "super":
            base = base[:-1]
        elif word.group() != "self":
            base = base + (word.group(),)
        if code.startswith("::", at):
            at += 2
            continue
        renamed = re.compile(r"\s+as\s+\w+").match(code, at)
        at = renamed.end() if renamed else at
        break
    path = base
    while path and path not in modules:
        path = path[:-1]
    if path in modules:
        found.add(path)
    return at


def skip_blanks(code, at):
    while at < len(code) and code[at].isspace():
        at += 1
    return at


def strongly_connected(graph):
    """Tarjan's components, without recursion."""
    index, low, on_stack, stack, found = {}, {}, set(), [], []
    for root in graph:
        if root in index:
            continue
        work = [(root, iter(sorted(graph[root])))]
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        while work:
            node, edges = work[-1]
            for other in edges:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(sorted(graph[other]))))
                    break
                if other in on_stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    component = []
                    while True:
                        other = stack.pop()
                        on_stack.discard(other)
                        component.append(other)
                        if other == node:
                            break
                    found.append(component)
    return found


def circles(room):
    """Sizes of the circles of files in a room that import each other, the largest first."""
    sources = {source.module: source for source in SOURCES if source.room == room}
    graph = {module: used_modules(source, sources) - {module} for module, source in sources.items()}
    sizes = [len(component) for component in strongly_connected(graph) if len(component) > 1]
    return sorted(sizes, reverse=True)


def tests_in(*prefixes):
    """`#[test]` functions in files below these."""
    return sum(
        len(re.findall(r"#\[test\]", text))
        for path, text in rust_files("src", "tests")
        if path.startswith(prefixes)
    )


def functions_in(prefix):
    return sum(len(re.findall(r"\bfn \w+", source.code)) for source in SOURCES if source.path.startswith(prefix))


# ---- words ----

DOC = re.compile(r"^\s*//[/!] ?(.*)$", re.M)


def doc_first_words():
    """Doc lines that begin a doc block, or a sentence at a line's begin, with these words."""
    words = collections.Counter()
    for source in SOURCES:
        for match in DOC.finditer(source.text):
            first = re.match(r"(\w+)", match.group(1))
            if first:
                words[first.group(1)] += 1
    return words


def word_counts(names):
    counts = collections.Counter()
    pattern = re.compile(r"\b(" + "|".join(names) + r")\b", re.I)
    for source in SOURCES:
        counts.update(match.group(1).lower() for match in pattern.finditer(source.text))
    return counts


TYPE = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?(?:struct|enum|trait|union|type) ([A-Z]\w*)", re.M)


def ambiguous_types():
    """Type names that are defined more than once in `src`, tests left out; associated types are no definitions."""
    where = collections.defaultdict(list)
    for source in SOURCES:
        for match in TYPE.finditer(source.code):
            line = source.code[match.start() : source.code.find("\n", match.end())]
            if re.search(r"\btype\b", line) and line.startswith("    "):
                continue
            where[match.group(1)].append(source.path)
    return {name: paths for name, paths in where.items() if len(paths) > 1}


def tuple_lets():
    """`let (a, b, c) = (x, y, z);`: three and more values bound in one statement by tuples on both sides."""
    count = 0
    for source in SOURCES:
        for match in re.finditer(r"\blet (?:mut )?\(([^()=]*(?:\([^()]*\)[^()=]*)*)\)\s*=\s*\(", source.code):
            if match.group(1).count(",") >= 2:
                count += 1
    return count


def old_constructors():
    """Functions called `of` without a receiver. `masks.of(photo)` is a query; `Mask::of(photo)` does not say what it does."""
    return sum(len(re.findall(r"\bfn of\s*(?:<[^>]*>)?\((?!\s*&?\s*(?:'\w+\s+)?(?:mut\s+)?self\b)", source.code)) for source in SOURCES)


def retired_identifiers():
    """Words of `tests/retired_words.txt` in identifiers of `src`."""
    path = os.path.join(ROOT, "tests/retired_words.txt")
    if not os.path.exists(path):
        return None
    words = {line.split("\t")[0].strip() for line in open(path, encoding="utf-8") if line.strip() and line[0] != "#"}
    count = collections.Counter()
    for _, text in rust_files("src"):
        for word in re.findall(r"\b[A-Za-z_]\w*\b", without_comments_and_literals(text)):
            if len([part for part in word.split("_") if part]) > 4:
                continue  # a sentence: the name of a test
            for part in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", word):
                if part.lower() in words:
                    count[part.lower()] += 1
    return count


# ---- the library ----

ITEM = re.compile(
    r"^(?P<indent>\s*)pub (?:const |async |unsafe )*(?P<kind>fn|struct|enum|trait|type|const|static|union) (?P<name>\w+)", re.M
)
CONST_FN = re.compile(r"pub const fn")


def facade():
    """Functions (methods too), types, traits and constants that a user of the crate can name.

    Modules are walked from `lib.rs` through `pub mod`. What is `pub use`d from a module that is not `pub` counts with the
    public methods of its own `impl` blocks; what is `pub use`d from one that is was counted there. Behind
    `#[doc(hidden)]` nothing counts.
    """
    by_module = {source.module: source for source in SOURCES if source.path != "src/main.rs"}
    count = collections.Counter()
    walk, seen, uses = [()], set(), []
    while walk:
        module = walk.pop()
        source = by_module.get(module)
        if source is None or module in seen:
            continue
        seen.add(module)
        code = source.code
        for match in re.finditer(r"(#\[doc\(hidden\)\]\s*)?^pub mod (\w+)\s*;", code, re.M):
            if not match.group(1):
                walk.append(module + (match.group(2),))
        hidden = [(m.start(), braces_end(code, code.find("{", m.end()))) for m in re.finditer(r"#\[doc\(hidden\)\]", code)]
        for match in ITEM.finditer(code):
            if not any(start <= match.start() < end for start, end in hidden):
                count["fn" if match.group("kind") == "fn" else match.group("kind")] += 1
        for match in re.finditer(r"^pub use ([^;]+);", code, re.M):
            uses.extend((module, name) for name in used_names(match.group(1)))
    for module, path in uses:
        base = () if path[0] == "crate" else module
        if path[0].startswith("quadratura_"):
            base, path = (), ("crate", path[0][len("quadratura_") :]) + path[1:]
        parts = tuple(part for part in path if part not in ("crate", "self"))
        home = base + parts[:-1]
        if path[0] == "super":
            home = module[:-1] + parts[1:-1]
        if home in seen or home not in by_module:
            continue
        name, code = parts[-1], by_module[home].code
        kind = re.search(r"pub (?:const |async |unsafe )*(fn|struct|enum|trait|type|const|static) " + name + r"\b", code)
        count[kind.group(1) if kind else "struct"] += 1
        below = [other for other in by_module.values() if other.module[: len(home)] == home]
        for other in below:
            for match in re.finditer(r"^impl(?:<[^{]*?>)? " + name + r"\b[^{]*\{", other.code, re.M):
                if " for " not in match.group():
                    body = other.code[match.end() : braces_end(other.code, match.end() - 1)]
                    count["fn"] += len(re.findall(r"^\s*pub (?:const |async |unsafe )*fn ", body, re.M))
    return sum(count.values()), count


def used_names(tree):
    """The paths that a `use` tree names, as tuples of words."""
    tree = re.sub(r"\s+", " ", tree).strip()
    match = re.match(r"^((?:\w+::)*)\{(.*)\}$", tree)
    if not match:
        yield tuple(tree.split(" as ")[0].split("::"))
        return
    before = tuple(word for word in match.group(1).split("::") if word)
    depth, part = 0, ""
    for letter in match.group(2) + ",":
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            for names in used_names(part) if part.strip() else ():
                yield before + (names[:-1] if names[-1] == "self" else names)
            part = ""
        else:
            part += letter


def doctests():
    """Fenced examples in the crate's docs that are compiled and run (`no_run` counts apart)."""
    runs = compiles = 0
    for source in SOURCES:
        inside = False
        for line in DOC.findall(source.text):
            if match := re.match(r"\s*```(.*)$", line):
                if not inside:
                    kind = match.group(1).strip()
                    if kind in ("", "rust", "should_panic"):
                        runs += 1
                    elif kind == "no_run":
                        compiles += 1
                inside = not inside
    return runs, compiles


def commands_in_messages():
    """Lines of the rooms that read and write files, and of `recipe`, whose string literals tell a user to type a command of the program."""
    count = 0
    for source in SOURCES:
        if source.room not in ("import", "ldi", "foliage", "io", "recipe"):
            continue
        for line in source.text.splitlines():
            if not re.match(r"\s*//", line) and re.search(r'`quadratura |--[a-z]+(?:-[a-z]+)*`', line):
                count += 1
    return count


def bare_indices():
    """Parameters and fields of public items called `photo`, `layer`, `face`, `object`, `element`, `place` or `index` (or
    their plurals) whose type is `usize` or `u32`, or a collection of them. A plural with a single number, such as
    `faces: usize` in a report, says how many there are: it is a count and no index."""
    name = r"(?:photo|layer|face|object|element|place|index|stack|view|key)"
    several = r"(?:Vec<usize>|&\[usize\]|\(usize, usize\)|Vec<\(usize, usize\)>)"
    bare = rf"(?:{name}: (?:usize|u32|Option<usize>|{several})|{name}s: {several})"
    count = 0
    for source in SOURCES:
        for match in re.finditer(r"pub fn \w+[^{;]*", source.code):
            count += len(re.findall(rf"\b{bare}", match.group()))
        count += len(re.findall(rf"^\s*pub {bare}", source.code, re.M))
    return count


# ---- pictures ----

HELPERS = {
    "bilinear samplers": r"fn \w*(?:bilinear|sample_at|sampled|interpolat)\w*\s*[(<]",
    "halvers": r"fn \w*(?:halve|halved|half_of|shrunk|downsample)\w*\s*[(<]",
    "compositing 'over'": r"fn \w*(?:\bover|_over|blend_over|composite)\w*\s*[(<]",
    "medians and quantiles": r"fn \w*(?:median|quantile|percentile)\w*\s*[(<]",
}
CONTAINER = re.compile(
    r"struct (\w+)(?:<[^>]*>)?\s*\{([^}]*\b(?:width|size)\b[^}]*\bVec<[^}]*|[^}]*\bVec<[^}]*\b(?:width|size)\b[^}]*)\}"
)


def picture_helpers():
    table = {}
    for name, pattern in HELPERS.items():
        table[name] = [source.path for source in SOURCES for _ in re.finditer(pattern, source.code)]
    table["structs of pixels with their width"] = [
        f"{source.path}:{match.group(1)}" for source in SOURCES for match in CONTAINER.finditer(source.code)
    ]
    return table


# ---- seams ----


def early_returns():
    """`let Some(...) = ... else { return }` in tests: where nothing is there to test with, the test reads as passed."""
    return sum(len(re.findall(r"else\s*\{\s*return;?\s*\}", text)) for path, text in rust_files("tests"))


def snapshot_bytes():
    total = 0
    for path, _, names in os.walk(os.path.join(ROOT, "tests/snapshots")):
        total += sum(os.path.getsize(os.path.join(path, name)) for name in names)
    return total


def wildcard_matches(*types):
    """`_ =>` in a `match` whose arms name variants of these types."""
    count = 0
    for source in SOURCES:
        for match in re.finditer(r"\bmatch [^{;]*\{", source.code):
            body = source.code[match.end() : braces_end(source.code, match.end() - 1)]
            if re.search(r"\b(?:" + "|".join(types) + r")::\w+", body.split("_ =>")[0]) and re.search(r"(?<!\w)_ =>", body):
                count += 1
    return count


def main():
    verbose = "--verbose" in sys.argv[1:]
    out = []

    def row(what, figure):
        out.append(f"{what:<74} {figure}")

    out.append("Lines of src by room (files, lines)")
    rooms = lines_by_room()
    for room, (files, lines) in sorted(rooms.items()):
        row(f"  {room}", f"{files:>4} {lines:>7}")
    row("  all", f"{sum(f for f, _ in rooms.values()):>4} {sum(l for _, l in rooms.values()):>7}")

    out.append("Circles of files that import each other, by room (the sizes of the largest five)")
    for room in sorted(rooms):
        row(f"  {room}", circles(room)[:5] or "none")

    out.append("The window")
    methods, blocks = editor_methods()
    row("  public fields of Editor", editor_fields())
    row("  methods of Editor, impl blocks", f"{methods}, {blocks}")
    row("  functions that draw (take a Ui) with &mut Editor", drawing_with_editor())
    row("  functions, unit tests in app", f"{functions_in('src/app/')}, {tests_in('src/app/')}")
    row("  of these: tests of actions, state and life cycle", tests_in("src/app/action/", "src/app/state/", "src/app/work/"))

    out.append("Words")
    first = doc_first_words()
    for word in ("What", "Of", "Its", "Whoever", "Somebody", "Nobody", "Whether"):
        row(f"  doc lines that begin with {word!r}", first[word])
    counts = word_counts(["whoever", "somebody", "nobody"])
    row("  'whoever', 'somebody', 'nobody' anywhere in src", ", ".join(str(counts[w]) for w in ("whoever", "somebody", "nobody")))
    ambiguous = ambiguous_types()
    row("  type names that mean two or more types", len(ambiguous))
    if verbose:
        for name, paths in sorted(ambiguous.items(), key=lambda item: -len(item[1])):
            out.append(f"      {name}: {', '.join(paths)}")
    row("  lets of three and more values by tuples", tuple_lets())
    row("  constructors called `of`", old_constructors())
    retired = retired_identifiers()
    if retired is not None:
        row("  retired words in identifiers", sum(retired.values()))
        if verbose:
            out.append(f"      {dict(retired)}")

    out.append("The library")
    total, kinds = facade()
    row("  public items (functions, types, traits, constants)", f"{total}  ({dict(sorted(kinds.items()))})")
    runs, compiles = doctests()
    row("  doctests that run, that are compiled only", f"{runs}, {compiles}")
    row("  lines of readers, writers and recipe that tell to type a command", commands_in_messages())
    row("  bare indices in public signatures and fields", bare_indices())

    out.append("Pictures")
    for name, where in picture_helpers().items():
        row(f"  {name}", len(where))
        if verbose:
            out.extend(f"      {path}" for path in where)

    out.append("Seams")
    row("  early returns in tests", early_returns())
    row("  bytes of tests/snapshots", snapshot_bytes())
    row("  matches on Mode, Shown or DisplayMode with a wildcard", wildcard_matches("Mode", "Shown", "DisplayMode"))
    print("\n".join(out))


if __name__ == "__main__":
    main()
