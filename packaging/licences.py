#!/usr/bin/env python3
"""Prints the licences of all packages that are compiled into the program: python3 packaging/licences.py [TARGET]

One entry for each text, with the packages that have it. A package without a file of its licence is listed with its licence's
name; where one has no licence at all, this fails."""

import json
import pathlib
import subprocess
import sys

NAMES = ("LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE")


def packages(target):
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    of_id = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    # Only what is linked: neither tools of the build nor of the tests.
    reached, waiting = set(), [metadata["resolve"]["root"]]
    while waiting:
        one = waiting.pop()
        if one in reached:
            continue
        reached.add(one)
        for dependency in nodes[one]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    found = [of_id[one] for one in reached if of_id[one]["source"] is not None]
    return sorted(found, key=lambda package: (package["name"], package["version"]))


def texts(package):
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [file for file in folder.iterdir() if file.is_file() and file.name.upper().startswith(NAMES)]
    # Fonts have licences of their own.
    files = sorted(files + list(folder.glob("fonts/*.txt")))
    return ["\n".join(line.rstrip() for line in file.read_text("utf-8", "replace").strip().splitlines()) for file in files]


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else "x86_64-unknown-linux-gnu"
    of_text, bare = {}, []
    for package in packages(target):
        name = f"{package['name']} {package['version']} ({package['license'] or 'see its file'})"
        found = texts(package)
        if not found:
            if not package["license"]:
                sys.exit(f"{name}: neither a licence nor a file of one")
            bare.append(name)
        for text in found:
            of_text.setdefault(text, []).append(name)
    print("Quadratura contains the packages below, under the licences that follow their names.")
    for text, names in sorted(of_text.items(), key=lambda entry: entry[1]):
        print("\n" + "=" * 80)
        print("\n".join(names))
        print("-" * 80)
        print(text)
    if bare:
        print("\n" + "=" * 80)
        print("These have no file of their licence, which is the one named:")
        print("\n".join(bare))


main()
