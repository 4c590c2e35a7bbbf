//! A board is made ready for a run: hello, parameters, map.

use controller_core::config::{Config, PARAMETERS};
use controller_core::kohonen::map::Map;
use controller_core::scalar::Scalar;
use heapless::Vec as FixedVec;
use protocol::convert::neuron_index;
use protocol::map_file::NeuronRecord;
use protocol::message::{
    Board, FromBoard, FromHost, Health, Hello, MapRequest, MapSummary, NEURONS_PER_MESSAGE, Neurons,
    PROTOCOL_VERSION, ParameterValue, Parameters, ScalarKind, Telemetry, TimeBase,
};
use protocol::schema;

use super::client::{Client, unexpected};
use super::error::LinkError;
use super::transport::Transport;
use crate::sil::{COLUMNS, HostMap, Indirect, ROWS};

/// What this program says of itself.
const BUILD_ID: &str = concat!("host_sim ", env!("CARGO_PKG_VERSION"));

/// The host's hello; `None` is any.
#[must_use]
pub fn greeting(board: Option<Board>, scalar: Option<ScalarKind>, time_base: TimeBase) -> Hello {
    Hello {
        protocol_version: PROTOCOL_VERSION,
        schema_hash: schema::HASH,
        build_id: BUILD_ID.try_into().unwrap_or_default(),
        board,
        scalar,
        map_hash: None,
        parameters_hash: None,
        time_base,
        epoch: 0,
    }
}

/// A session with a board that fits.
#[derive(Debug)]
pub struct Session<T> {
    /// The requests.
    pub client: Client<T>,
    /// What the board said last of itself.
    pub board: Hello,
    ours: Hello,
}

impl<T: Transport> Session<T> {
    /// Says hello to a board, and checks that it is the one expected; `None` is any.
    ///
    /// # Errors
    /// See [`LinkError`]; never later than [`Transport::answer_max`].
    pub fn open(
        transport: T,
        board: Option<Board>,
        scalar: Option<ScalarKind>,
        time_base: TimeBase,
    ) -> Result<Self, LinkError> {
        let ours = greeting(board, scalar, time_base);
        let mut client = Client::new(transport);
        let board = client.hello(ours.clone())?;
        ours.check_against(&board)?;
        Ok(Self { client, board, ours })
    }

    /// Asks the board once more what it is, and checks that it is what it should be.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn renew(&mut self) -> Result<(), LinkError> {
        self.board = self.client.hello(self.ours.clone())?;
        Ok(self.ours.check_against(&self.board)?)
    }

    /// Gives the board its parameters, unless it has them already.
    ///
    /// # Errors
    /// See [`LinkError`]; refused, the board keeps those it had.
    pub fn configure(&mut self, config: &Config) -> Result<(), LinkError> {
        self.ours.parameters_hash = None;
        self.renew()?;
        if self.board.parameters_hash == Some(config.hash()) {
            return Ok(());
        }
        self.client.command(&FromHost::Parameters(Parameters::Defaults))?;
        let default = Config::default();
        for index in 0..PARAMETERS.len() {
            let (wished, there) = (config.get(index), default.get(index));
            if let Some(value) = wished
                && wished.map(f32::to_bits) != there.map(f32::to_bits)
            {
                self.set(u8::try_from(index).unwrap_or(u8::MAX), value)?;
            }
        }
        self.commit()?;
        self.ours.parameters_hash = Some(config.hash());
        self.renew()
    }

    /// Stages one parameter.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn set(&mut self, index: u8, value: f32) -> Result<(), LinkError> {
        self.client.command(&FromHost::Parameters(Parameters::Set(ParameterValue { index, value })))
    }

    /// Has the board use the staged parameters.
    ///
    /// # Errors
    /// See [`LinkError`]; refused, it keeps those it had.
    pub fn commit(&mut self) -> Result<(), LinkError> {
        self.client.command(&FromHost::Parameters(Parameters::Commit))
    }

    /// All parameters, in the order of the list.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn parameters(&mut self) -> Result<Vec<f32>, LinkError> {
        (0..PARAMETERS.len())
            .map(|index| {
                let index = u8::try_from(index).unwrap_or(u8::MAX);
                match self.client.request(&FromHost::Parameters(Parameters::Get { index }))? {
                    FromBoard::Parameter(parameter) => Ok(parameter.value),
                    other => Err(unexpected("a parameter", &other)),
                }
            })
            .collect()
    }

    /// Gives the board a map that was trained for `steps` steps, unless it has it already.
    ///
    /// # Errors
    /// See [`LinkError`]; half a map on the board is found out by its hash.
    pub fn upload_map<S: Scalar>(
        &mut self,
        map: &HostMap<S, Indirect<S>>,
        steps: u32,
    ) -> Result<(), LinkError> {
        let hash = map.hash();
        let there = self.map_summary()?;
        if there.hash != hash {
            for first in (0..COLUMNS * ROWS).step_by(NEURONS_PER_MESSAGE) {
                let records: FixedVec<NeuronRecord, NEURONS_PER_MESSAGE> = (first..)
                    .take(NEURONS_PER_MESSAGE)
                    .map_while(neuron_index::<COLUMNS, ROWS>)
                    .map(|index| NeuronRecord::of(map, index))
                    .collect();
                let first = u16::try_from(first).unwrap_or(u16::MAX);
                self.client
                    .command(&FromHost::Map(MapRequest::Write(Neurons { first, neurons: records })))?;
            }
        }
        if there.hash != hash || there.trained_steps != steps {
            self.client.command(&FromHost::Map(MapRequest::Confirm { trained_steps: steps, hash }))?;
        }
        Ok(())
    }

    /// Has the board forget what it has learned.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn forget_map(&mut self) -> Result<(), LinkError> {
        self.client.command(&FromHost::Map(MapRequest::Forget))
    }

    /// What the board says of its map.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn map_summary(&mut self) -> Result<MapSummary, LinkError> {
        match self.client.request(&FromHost::Map(MapRequest::Describe))? {
            FromBoard::Map(summary) => Ok(summary),
            other => Err(unexpected("the map's hash", &other)),
        }
    }

    /// The board's map, bit for bit, and the training steps it has seen. `S` must be the board's scalar.
    ///
    /// # Errors
    /// See [`LinkError`]; what was read must have the hash that the board says its map has.
    pub fn download_map<S: Scalar>(&mut self) -> Result<(HostMap<S, Indirect<S>>, u32), LinkError> {
        let summary = self.map_summary()?;
        let mut map: HostMap<S, Indirect<S>> = Map::regular();
        let mut next = 0;
        while next < COLUMNS * ROWS {
            let first = u16::try_from(next).unwrap_or(u16::MAX);
            let request = FromHost::Map(MapRequest::Read { first });
            let neurons = match self.client.request(&request)? {
                FromBoard::Neurons(neurons) if neurons.first == first && !neurons.neurons.is_empty() => {
                    neurons
                }
                other => return Err(unexpected("neurons of the map", &other)),
            };
            for record in &neurons.neurons {
                if let Some(index) = neuron_index::<COLUMNS, ROWS>(next) {
                    record.put(&mut map, index);
                }
                next += 1;
            }
        }
        if map.hash() == summary.hash {
            Ok((map, summary.trained_steps))
        } else {
            Err(LinkError::Map { found: map.hash(), expected: summary.hash })
        }
    }

    /// Begins a run: the controller as after a start, at tick 0; map and parameters stay.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn begin(&mut self) -> Result<(), LinkError> {
        self.client.command(&FromHost::Begin)
    }

    /// Ends a run: the wheels stand still.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn stop(&mut self) -> Result<(), LinkError> {
        self.client.command(&FromHost::Disarm)?;
        self.client.command(&FromHost::Mode(controller_core::controller::Mode::Standby))
    }

    /// How link and tasks are doing.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn health(&mut self) -> Result<Health, LinkError> {
        match self.client.request(&FromHost::Health)? {
            FromBoard::Health(health) => Ok(health),
            other => Err(unexpected("health", &other)),
        }
    }

    /// What the controller thinks.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn telemetry(&mut self) -> Result<Telemetry, LinkError> {
        match self.client.request(&FromHost::Telemetry)? {
            FromBoard::Telemetry(telemetry) => Ok(telemetry),
            other => Err(unexpected("telemetry", &other)),
        }
    }
}
