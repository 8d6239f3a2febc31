#!/bin/sh
# The first process of a host: in namespaces of its own it is all that the host needs, and when it ends, the host is gone.
#
# usage: unshare -m -u -i -n -p --fork --mount-proc sh host.sh NAME ADDRESS FOLDER
# FOLDER holds `hosts` and `sshd`. It says `up`, wants a line when there is an `eth0`, says `ready`, and ends with its input.
set -eu
PATH=$PATH:/usr/sbin:/sbin
name=$1 address=$2 folder=$3
sshd=$(command -v sshd) || { echo "there is no sshd (openssh-server)" >&2; exit 1; }

hostname "$name"
# what else hosts on one machine would share
for own in /run /dev/shm; do mount -t tmpfs none "$own"; done
mkdir -p /run/sshd
mount --bind "$folder/hosts" /etc/hosts
ip link set lo up
echo up
read -r _
ip address add "$address/24" dev eth0
ip link set eth0 up
"$sshd" -f "$folder/sshd" -E "$folder/sshd-$name.log"
echo ready
# while it waits for this, it reaps what others leave, as a first process must
exec 3<&0
cat <&3 >/dev/null &
wait $!
