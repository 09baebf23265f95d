"""Names (of scenes, views, variants, metrics) as parts of paths; src/base/file_name.cpp does the same."""
MOST_CHARACTERS = 80
LEGAL = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._=+-")


def shortHash(text):
    """FNV-1a (Fowler, Noll, Vo)."""
    value = 2166136261
    for byte in text.encode("utf-8", "surrogateescape"):
        value = (value ^ byte) * 16777619 & 0xffffffff
    return value


def fileName(name):
    """What stands behind the name's last "/" as one part of a path. A hash follows where something was lost, so that
    two names never share a file."""
    part = ""
    for character in name.rpartition("/")[2]:
        if character in LEGAL:
            part += character
        elif not part.endswith("-"):
            part += "-"
    if not part or part[0] in ".-":
        part = "_" + part
    if part == name and len(part) <= MOST_CHARACTERS:
        return part
    return f"{part[:MOST_CHARACTERS - 9]}-{shortHash(name):08x}"
