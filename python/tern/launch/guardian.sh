# guardian.sh DIRECTORY RUN PYTHONPATH: ends what a killed launcher leaves behind.
#
# Standard input is a pipe from the launcher: "started PID" and "ended PID" for each process, "finished" at the end.
# End of file without "finished" means that the launcher died (kill -9, out of memory): the process groups still running
# are asked to end (SIGTERM, results are written), killed two seconds later, the private socket directory is removed, and
# RUN/run.json says how the run ended.
directory=$1
run=$2
export PYTHONPATH="$3"
running=
while read -r word pid; do
  case $word in
    started) running="$running $pid" ;;
    ended)
      rest=
      for other in $running; do
        if [ "$other" != "$pid" ]; then rest="$rest $other"; fi
      done
      running=$rest
      ;;
    finished) exit 0 ;;
  esac
done

signal_all() {
  for pid in $running; do kill -s "$1" -- "-$pid" 2>/dev/null; done
}

signal_all TERM
signal_all CONT
for tenth in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
  alive=
  for pid in $running; do
    if kill -s 0 -- "-$pid" 2>/dev/null; then alive=yes; fi
  done
  if [ -z "$alive" ]; then break; fi
  sleep 0.1
done
signal_all KILL
rm -rf -- "$directory" "/dev/shm/${directory##*/}"
/usr/bin/python3 -B -P -m tern.launch.epilogue "$run" 2>/dev/null
