#!/bin/bash
# bundle.sh -o FILE.tar.xz [-p PROGRAM]
# Packs the program (build/release/dapple unless named) and all it needs but the C library and GL into an archive
# that runs where it is unpacked. The same input gives the same bytes. Exit code 2: wrong use, or it cannot be done.
set -euo pipefail
export LC_ALL=C
unset LD_LIBRARY_PATH

root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
program=$root/build/release/dapple
file=
die() { printf 'bundle: %s\n' "$*" >&2; exit 2; }
while getopts o:p: option; do
    case $option in
        o) file=$OPTARG ;;
        p) program=$OPTARG ;;
        *) die "usage: bundle.sh -o FILE.tar.xz [-p PROGRAM]" ;;
    esac
done
[[ $file == *.tar.xz ]] || die "-o '$file': name a file that ends in .tar.xz"
[[ -x $program ]] || die "no program at $program: build it first, or name it with -p"
touch "$file.part" 2> /dev/null || die "cannot write $file: name another place with -o"

stage=$(mktemp -d)
trap 'rm -rf "$stage" "$file.part"' EXIT
top=$stage/dapple
mkdir -p "$top"/{bin,libexec,lib/c++,bench,licences}
strip -o "$top/libexec/dapple" "$program"
# The suite's data, found from the place of the program.
cp -r "$root/shaders" "$top/"
cp -r "$root/bench/sweeps" "$root/bench/report" "$top/bench/"
(cd "$root" && find scenegen -name '*.toml' -exec cp --parents {} "$top/" \;)
cp "$root/README.md" "$root/LICENSE" "$top/"
git -C "$root" describe --always --abbrev=40 --dirty --exclude='*' > "$top/commit" 2> /dev/null || rm "$top/commit"
find "$top" -name __pycache__ -prune -exec rm -r {} +

# keepLicence PACKAGE
keepLicence() {
    [[ ! -e $top/licences/$1 ]] || return 0
    local text=/usr/share/doc/$1/copyright
    [[ -e $text ]] || die "no licence of package $1 at $text: a bundle must carry it"
    cp -L "$text" "$top/licences/$1"
}

# packageOf FILE
packageOf() {
    local name path=${1#/usr}
    name=$(dpkg-query -S "/usr$path" "$path" "$(readlink -f "$1")" 2> /dev/null | head -n 1) || true
    [[ -n $name ]] || die "no package owns $1: its licence is unknown, and a bundle must carry it"
    echo "${name%%[:,]*}"
}

# GL must be the machine's own, for it talks to the machine's driver; so must the C library, which loads it.
while read -r name _ path _; do
    case $name in
        linux-vdso.* | /*) ;;
        libc.so.* | libm.so.* | libmvec.so.* | libpthread.so.* | libdl.so.* | librt.so.*) ;;
        libGL* | libEGL* | libOpenGL*) ;;
        *)
            [[ $path == /* ]] || die "$program needs $name, which is not found here"
            case $name in
                libstdc++.so.* | libgcc_s.so.*) cp -L "$path" "$top/lib/c++/$name" ;;
                *) cp -L "$path" "$top/lib/$name" ;;
            esac
            package=$(packageOf "$path")
            keepLicence "$package"
            ;;
    esac
done < <(ldd "$program")

# Headers are compiled into the program: it carries their licences too, but for those of the tests.
while read -r name _; do
    case $name in
        libgtest-dev | libbenchmark-dev) ;;
        *-dev) keepLicence "$name" ;;
    esac
done < "$root/packages.txt"
# Debian's files name these by their place on a Debian machine.
for common in $(grep -rhoE '/usr/share/common-licenses/[A-Za-z0-9.+-]*[A-Za-z0-9]' "$top/licences" | sort -u); do
    [[ ! -e $common ]] || cp -L "$common" "$top/licences/"
done

newest() { sort -uV | tail -n 1; }
cxx=$(grep -aoE 'GLIBCXX_3\.4\.[0-9]+' "$top/lib/c++/libstdc++.so.6" | newest)
libc=$(find "$top/lib" "$top/libexec" -type f -exec objdump -T {} + | grep -oE 'GLIBC_2\.[0-9]+' | newest)
cat > "$top/bin/dapple" << LAUNCHER
#!/bin/sh
home=\$(dirname "\$(dirname "\$(readlink -f "\$0")")")
libc=\$(getconf GNU_LIBC_VERSION 2> /dev/null)
libc=\${libc#glibc }
if [ -n "\$libc" ] && [ "\$(printf '%s\n' "\$libc" ${libc#GLIBC_} | sort -V | head -n 1)" != ${libc#GLIBC_} ]; then
    echo "dapple: this machine's C library is \$libc; this bundle needs ${libc#GLIBC_} or newer: build from source here" >&2
    exit 2
fi
# Our C++ runtime serves only where the machine's is absent or older: the machine's GL driver may need its own.
for folder in /usr/lib/x86_64-linux-gnu /lib/x86_64-linux-gnu /usr/lib64 /lib64 /usr/lib; do
    if grep -q ${cxx//./\\.} "\$folder/libstdc++.so.6" 2> /dev/null; then exec "\$home/libexec/dapple" "\$@"; fi
done
LD_LIBRARY_PATH=\${LD_LIBRARY_PATH:+\$LD_LIBRARY_PATH:}\$home/lib/c++ exec "\$home/libexec/dapple" "\$@"
LAUNCHER
chmod 755 "$top/bin/dapple"
ln -s bin/dapple "$top/dapple"

tar -C "$stage" --sort=name --mtime=@1000000000 --owner=0 --group=0 --numeric-owner --mode=u+rwX,go+rX,go-w \
    --format=gnu -c dapple | xz -7 -T2 > "$file.part" || die "cannot write $file: the disk may be full"
mv "$file.part" "$file"
