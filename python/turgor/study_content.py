"""Content of the files that a scene names, for the keys of a study's members.

Files that the engine reads together with a named one count too: the samples of a MetaImage (.mhd) or NRRD (.nhdr) header, the
other file of a TetGen mesh (.node, .ele), the slices beside a DICOM slice, and the folders in a folder. As in the engine, a
format is recognized by the content of its file.
"""
import hashlib
import os
import pathlib
import re

_LONGEST_HEADER = 1 << 18  # of an image [bytes]
_NRRD_DATA = re.compile(rb"^data ?file: *([^\r\n]+)", re.MULTILINE | re.IGNORECASE)
_META_DATA = re.compile(rb"^[ \t]*ElementDataFile[ \t]*=[ \t]*([^\r\n]+)", re.MULTILINE)
_TETGEN_BEGIN = re.compile(rb"(?:\s|#[^\n]*\n)*\+?\d+\s+(?:3|4|10)\s")  # points and dimensions, or tets and nodes


def content_of(value, folder):
    """Value of a scene for hashing. Names of files, relative to `folder`, are replaced by hashes of their content."""
    if isinstance(value, dict):
        return {key: content_of(one, folder) for key, one in value.items()}
    if isinstance(value, list):
        return [content_of(one, folder) for one in value]
    if not isinstance(value, str) or not value:
        return value
    path = folder / value
    if os.path.isfile(path):
        companions = _companions(path)
        return [_hash(path), *map(_hash, companions)] if companions else _hash(path)
    if os.path.isdir(path):
        return [[file.relative_to(path).as_posix(), _hash(file)] for file in sorted(_files_below(path))]
    return value


def _hash(file):
    with open(file, "rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()


def _files_below(folder):
    """Files of a folder and of its folders; hidden folders do not count, as for the reader of DICOM."""
    for at, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (file for name in names if (file := pathlib.Path(at, name)).is_file())


def _is_dicom(head):
    return head[128:132] == b"DICM" or (head[:1] in (b"\x02", b"\x08") and head[1:2] == b"\0" and head[3:4] == b"\0")


def _companions(file):
    """Other files that the engine reads with this one, as far as they exist."""
    with open(file, "rb") as content:
        head = content.read(_LONGEST_HEADER)
    if _is_dicom(head):
        return [other for other in sorted(file.parent.iterdir()) if other != file and other.is_file()]
    if _TETGEN_BEGIN.match(head):
        names = [file.with_suffix(ending).name for ending in (".node", ".ele")]
    else:
        found = (_NRRD_DATA if head.startswith(b"NRRD") else _META_DATA).search(head)
        names = [os.fsdecode(found[1].strip())] if found else []
    others = [file.parent / name for name in names if "\0" not in name]
    return [other for other in others if other != file and other.is_file()]
