//! The runs of members: each a process of its own, so many at once, each with its log.
//!
//! Processes stand in groups of their own: a signal of the terminal reaches this program alone, which hands it on. So each run gets it once, keeps a
//! checkpoint and ends, and the next call goes on with it.

use std::collections::VecDeque;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicI32, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process, waitid};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::error::{Error, say};
use crate::pipeline::is_stopped_by_hang_up;
use crate::plain_file::read_to_string;
use crate::study::{State, keep_failure, run_of, scenario_of, state};

/// How the members are run.
pub(super) struct Work<'a> {
    /// The folder of the study.
    pub study: &'a Path,
    /// How many members the study has.
    pub members: usize,
    /// So many at once.
    pub jobs: usize,
    /// Threads of each.
    pub threads: usize,
    /// Whether members that failed run again.
    pub retry: bool,
    /// Members that run again though they are done.
    pub again: &'a [usize],
    /// Whether progress stays silent.
    pub quiet: bool,
}

/// The exit code of a run that can't go on: the program or an input has changed.
const REFUSED: Option<i32> = Some(4);

/// How a member ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ended {
    pub member: usize,
    /// Why it is not done; none where it is.
    pub failure: Option<String>,
}

/// What the workers share.
struct Shared {
    waiting: Mutex<VecDeque<usize>>,
    running: Mutex<Vec<Pid>>,
    ended: Mutex<Vec<Ended>>,
    /// The last signal; 0 before any.
    signal: AtomicI32,
    done: AtomicUsize,
}

/// What a lock holds; a worker that broke down leaves nothing half done.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Work<'_> {
    /// Runs members to their end, and says how each ended, in their order.
    ///
    /// # Errors
    /// [`Error::StudyStopped`] after a signal, and where a process or its log cannot be made.
    pub fn run(&self, members: Vec<usize>, done: usize) -> Result<Vec<Ended>, Error> {
        let shared = Shared {
            waiting: Mutex::new(members.into()),
            running: Mutex::default(),
            ended: Mutex::default(),
            signal: AtomicI32::new(0),
            done: AtomicUsize::new(done),
        };
        let failed = |cause: io::Error| Error::Internal(format!("signals cannot be watched: {cause}"));
        let hang_up = Some(SIGHUP).filter(|_| is_stopped_by_hang_up());
        let mut signals = Signals::new([SIGINT, SIGTERM].into_iter().chain(hang_up)).map_err(failed)?;
        let handle = signals.handle();
        let worked = std::thread::scope(|scope| {
            scope.spawn(|| signals.forever().for_each(|signal| shared.hand_on(signal)));
            let workers: Vec<_> = (0..self.jobs).map(|_| scope.spawn(|| self.work(&shared))).collect();
            let worked: Vec<_> = workers.into_iter().map(|worker| worker.join()).collect();
            handle.close();
            worked
        });
        for result in worked {
            result.unwrap_or_else(|_| Err(Error::Internal("a worker broke down".to_owned())))?;
        }
        let mut ended = locked(&shared.ended).clone();
        ended.sort_by_key(|one| one.member);
        match shared.signal.into_inner() {
            0 => Ok(ended),
            signal => Err(Error::StudyStopped {
                signal,
                done: shared.done.into_inner(),
                members: self.members,
                folder: self.study.to_owned(),
            }),
        }
    }

    /// Takes members until none is left, or a signal came.
    fn work(&self, shared: &Shared) -> Result<(), Error> {
        while shared.signal.load(Ordering::Relaxed) == 0 {
            let Some(member) = locked(&shared.waiting).pop_front() else { break };
            let begin = Instant::now();
            let ended = self
                .one(shared, member)
                .map_err(|cause| Error::Output { path: self.log(member), cause: cause.to_string() })?;
            // What a signal ended is neither done nor failed.
            let Some(ended) = ended else { continue };
            let done = shared.done.fetch_add(usize::from(ended.failure.is_none()), Ordering::Relaxed)
                + usize::from(ended.failure.is_none());
            if !self.quiet {
                let how = ended.failure.as_ref().map_or("done".to_owned(), |why| format!("failed ({why})"));
                let seconds = begin.elapsed().as_secs_f64();
                say(format!("member {member}: {how} in {seconds:.1} s; {done} of {} done", self.members));
            }
            locked(&shared.ended).push(ended);
        }
        Ok(())
    }

    /// Runs one member; none where a signal came before its end.
    fn one(&self, shared: &Shared, member: usize) -> io::Result<Option<Ended>> {
        /// Between two looks at a member that another process runs.
        const PAUSE: Duration = Duration::from_millis(200);
        let ended = |failure| Ok(Some(Ended { member, failure }));
        let mut retry = self.retry;
        while shared.signal.load(Ordering::Relaxed) == 0 {
            let way = match state(self.study, member) {
                State::InUse => {
                    std::thread::sleep(PAUSE);
                    continue;
                }
                State::Done if !self.again.contains(&member) => return ended(None),
                State::Failed(why) if !retry => return ended(Some(why)),
                State::CutOff => Way::GoOn,
                State::New { replaces: false } => Way::Begin,
                State::New { .. } | State::Failed(_) | State::Done => Way::Replace,
            };
            keep_failure(self.study, member, None)?;
            let code = match self.process(shared, member, way)? {
                REFUSED if way == Way::GoOn && retry => self.process(shared, member, Way::Replace)?,
                code => code,
            };
            // What another process runs is waited for.
            if code == Some(0) || state(self.study, member) != State::InUse {
                return self.how(shared, member, code);
            }
            retry = false;
        }
        Ok(None)
    }

    /// How a member ended whose process had this exit code.
    fn how(&self, shared: &Shared, member: usize, code: Option<i32>) -> io::Result<Option<Ended>> {
        let is_stopped = shared.signal.load(Ordering::Relaxed) != 0;
        let failure = match code {
            Some(0) => None,
            _ if is_stopped => return Ok(None),
            Some(code) => Some(format!("exit code {code}: {}", self.last_error(member))),
            None => Some("it was killed; `floodsim matrix` goes on with it".to_owned()),
        };
        // What would end so again; a full disk or a checkpoint that another program wrote need not.
        let is_lasting = matches!(code, Some(3..=5)) && matches!(state(self.study, member), State::New { .. });
        if is_lasting {
            keep_failure(self.study, member, failure.as_deref())?;
        }
        Ok(Some(Ended { member, failure }))
    }

    /// Runs a process to its end, its output in the log. None where a signal ended it.
    fn process(&self, shared: &Shared, member: usize, way: Way) -> io::Result<Option<i32>> {
        let mut log = OpenOptions::new().create(true).append(true).open(self.log(member))?;
        let run = run_of(self.study, member);
        let scenario = scenario_of(self.study, member);
        let (verb, what) = if way == Way::GoOn { ("resume", &run) } else { ("run", &scenario) };
        writeln!(log, "floodsim {verb} {} --threads {}", what.display(), self.threads)?;
        // This program, also where another one has taken its place on the disk since.
        let mut command = Command::new("/proc/self/exe");
        command.arg(verb).arg(what).args(["--quiet", "--threads", &self.threads.to_string()]);
        if way != Way::GoOn {
            command.arg("--out").arg(&run);
        }
        if way == Way::Replace {
            command.arg("--overwrite");
        }
        command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log).process_group(0);
        // Made while the list is held: a signal that comes now finds it there.
        let (child, pid) = {
            let mut running = locked(&shared.running);
            if shared.signal.load(Ordering::Relaxed) != 0 {
                return Ok(None);
            }
            let child = command.spawn()?;
            let pid = Pid::from_child(&child);
            running.push(pid);
            (child, pid)
        };
        shared.wait(child, pid)
    }

    fn log(&self, member: usize) -> std::path::PathBuf {
        self.study.join(format!("logs/{member:04}.txt"))
    }

    /// The last error of the log of a member, in one line.
    fn last_error(&self, member: usize) -> String {
        let log = read_to_string(self.log(member)).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        // Of this process alone.
        let begin = lines.iter().rposition(|line| line.starts_with("floodsim r")).unwrap_or(0);
        let lines = &lines[begin..];
        let last = lines.iter().rposition(|line| line.starts_with("error"));
        let words = last.map(|at| match lines.get(at + 1) {
            Some(message) if lines[at].starts_with("error[") => format!("{} {}", lines[at], message.trim()),
            _ => lines[at].to_owned(),
        });
        words.unwrap_or_else(|| format!("see {}", self.log(member).display()))
    }
}

/// How a process begins.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Begin,
    Replace,
    GoOn,
}

impl Shared {
    /// Hands a signal on to all runs.
    fn hand_on(&self, signal: i32) {
        self.signal.store(signal, Ordering::Relaxed);
        let kind = match signal {
            SIGINT => Signal::INT,
            SIGHUP => Signal::HUP,
            _ => Signal::TERM,
        };
        for pid in locked(&self.running).iter() {
            // One that has just ended needs none.
            let _ = kill_process(*pid, kind);
        }
    }

    /// Waits for the end of a run. Its number is given back to the system only when no signal can be sent to it any more.
    fn wait(&self, mut child: Child, pid: Pid) -> io::Result<Option<i32>> {
        let ended = loop {
            match waitid(WaitId::Pid(pid), WaitIdOptions::EXITED | WaitIdOptions::NOWAIT) {
                Err(rustix::io::Errno::INTR) => {}
                other => break other,
            }
        };
        locked(&self.running).retain(|other| *other != pid);
        ended?;
        Ok(child.wait()?.code())
    }
}
