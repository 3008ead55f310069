# Sourced by each script here: an empty folder that is removed at the end, and pinned software in it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Packages of Python, in an environment of their own: "$folder/venv/bin/python".
packages() {
  python3 -m venv "$folder/venv"
  "$folder/venv/bin/pip" install --quiet "$@"
}

# CalculiX of Debian 12, unpacked and not installed: "$folder/root/usr/bin/ccx" with "$libraries".
calculix() {
  (
    cd "$folder"
    apt-get download -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2 libarpack2 >/dev/null
    for package in *.deb; do dpkg --extract "$package" root; done
  )
  libraries=$(find "$folder/root" -name 'lib*.so*' -printf '%h\n' | sort --unique | paste --serial --delimiters=:)
}
